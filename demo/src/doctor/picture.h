#pragma once

#include <coppice/coppice.h>

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/vec3.hpp>

namespace forest {

using Context = std::unique_ptr<coppice_context, void (*)(coppice_context*)>;

/// Pictures are square.
inline constexpr std::uint32_t kPictureSide_px = 256;
/// The near plane of all cameras, m. Depth is reversed and infinite: kNear_m / distance.
inline constexpr float kNear_m = 0.1f;

/// Hazels, and where they are looked at from.
struct Stand {
  std::vector<coppice_placement> plants;
  coppice_camera camera;  ///< its view is set where it is used
};

/// What a stand looks like.
struct Picture {
  std::vector<float> depth;      ///< 0 where nothing is
  std::vector<glm::vec3> color;  ///< the processor's is albedo, linear
  Picture() : depth(std::size_t{kPictureSide_px} * kPictureSide_px), color(depth.size()) {}
};

/// How a picture differs from the processor's. All are shares of 1.
struct Difference {
  float coverage = 0;  ///< in blocks of 8 x 8 px that either covers: root mean square of the difference in coverage
  float depth = 0;     ///< mean over pixels that both cover
  float color = 0;     ///< in the same blocks: root mean square; uncovered pixels are black
};
Difference difference_of(const Picture& picture, const Picture& reference);

/// The hazel's file.
struct Bytes {
  const void* data;
  std::size_t size;
};
Bytes hazel();

/// What the processor selects and draws, by a context without a renderer.
struct Reference {
  Picture picture;
  std::uint32_t instances = 0;  ///< in view
  double leaves = 0;            ///< drawn
};
/// errors  Failure
Reference draw_on_processor(const Stand& stand);

/// errors  Failure with the library's reason
void check(const coppice_context* context, coppice_status status, const char* call);

}  // namespace forest
