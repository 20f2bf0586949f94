#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kMaxViewCount = 1024;

/// A camera on the sphere of directions; pixels are square, and the image holds the bounding sphere exactly. right x up = direction: the
/// axes are right-handed and the camera looks along -direction.
struct Viewpoint {
  glm::vec3 direction{0.0f};    ///< unit, from the plant's centre towards the camera
  glm::vec3 right{0.0f};        ///< unit, image +x
  glm::vec3 up{0.0f};           ///< unit, image -y (rows go down)
  float distance_radii = 0.0f;  ///< above 1: a perspective camera so many radii of the sphere from its centre; 0: orthographic
};

/// The viewpoint in a direction: up is as near world +Y as it gets (world +Z for a camera within half a degree of the Y axis).
/// direction  unit
Viewpoint viewpoint_towards(const glm::vec3& direction);

/// `count` viewpoints: 20 are the vertices of a regular dodecahedron (the paper's), any other count a Fibonacci sphere.
/// errors  invalid_argument: count is 0 or over kMaxViewCount
Result<std::vector<Viewpoint>> viewpoints(std::uint32_t count);

}  // namespace coppice::bake
