#pragma once

#include <coppice/vulkan.h>

#include <mutex>
#include <string>
#include <vector>

#include "picture.h"
#include "resources.h"

namespace forest {

/// What the library has logged, from any thread.
struct Notes {
  std::mutex mutex;
  std::vector<std::string> warnings, errors;
};

enum class Until { uploaded, culled, drawn };

struct StageDesc {
  coppice_output output = COPPICE_OUTPUT_LIT;
  bool compute = false;  ///< compute shaders draw small leaves
};

/// A stand of plants and one view of them on a device.
struct Stage {
  const Device& device;
  Notes notes;
  Context context{nullptr, coppice_context_destroy};
  coppice_camera camera;
  coppice_output output;
  std::vector<Image> colors;
  Image depth;
  std::uint64_t frame = 0;

  /// errors  Failure
  Stage(const Device& device, const Stand& stand, const StageDesc& desc);
};

/// One frame, and waits for it. errors  Failure
void draw_frame(Stage& stage, Until until);
/// Frames until all that the view wants is there and the GPU's figures are of it. errors  Failure
void draw_until_settled(Stage& stage, Until until);
/// Reads the last frame; its colours are those of the first attachment. errors  Failure
Picture read_picture(const Stage& stage);

}  // namespace forest
