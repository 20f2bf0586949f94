#pragma once

// One plant before the camera, drawn through the C API: for tests of looks and for golden pictures.

#include <cstdint>
#include <filesystem>
#include <memory>

#include <glm/vec3.hpp>

#include "coppice/vulkan.h"
#include "looks_measure.h"
#include "shot.h"
#include "vulkan_device.h"

namespace coppice::test {

enum class LooksPath { hardware, compute };

/// m, in the plant's space
struct LooksSphere {
  glm::vec3 center{0.0f};
  float radius = 1;
};

struct LooksView {
  LooksSphere sphere;   ///< in the middle of the picture
  float size_px = 240;  ///< the sphere's width
  glm::vec3 from{0.6f, 0.25f, 1.0f};
  coppice_lod_mode lod = COPPICE_LOD_CUT;
  float error_px = 2;               ///< as in coppice_camera
  glm::vec3 sun{0.5f, 0.8f, 0.4f};  ///< towards it
  bool mean_of_light = false;  ///< as temporal antialiasing has it; else the mean of what is displayed, in which bright details count less
  bool y_up = false;           ///< upside down: the picture's y points up, against Vulkan's
};

class LooksStage {
 public:
  /// plant: a .coppice file. Throws std::runtime_error where it cannot be opened.
  LooksStage(const VulkanDevice& gpu, const std::filesystem::path& plant, LooksPath path);

  /// The plant's bounding sphere.
  [[nodiscard]] LooksSphere sphere() const;

  /// Streams until all that the view wants is there, then draws 16 frames, each moved by part of a pixel.
  MeanPicture draw(const LooksView& view);
  /// The same with a single frame, on a background of this colour.
  Picture draw_still(const Shot& view, const VkClearColorValue& background);
  /// What the frames of the view drew.
  [[nodiscard]] coppice_view_stats stats() const;

 private:
  void begin_frame(const Shot& view);
  void record_cull(VkCommandBuffer cmd, const Shot& view);
  void settle(const Shot& view);
  Picture draw_frame(const Shot& view, const Attachments& attachments);

  const VulkanDevice& gpu_;
  std::unique_ptr<coppice_context, decltype(&coppice_context_destroy)> context_{nullptr, coppice_context_destroy};
  coppice_view view_ = 0;
  coppice_plant_info info_{};
  std::uint64_t frame_number_ = 0;
};

}  // namespace coppice::test
