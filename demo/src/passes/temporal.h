#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

#include "resources.h"

namespace forest {

/// Temporal antialiasing. Frames are drawn moved by parts of a pixel, tone-mapped, and averaged: over the frames of a camera that stands
/// still as they are, of one that moves by looking up where each pixel's surface was in the frame before. Frames may be smaller than the
/// picture: a pixel then takes from each as much as that frame's nearest sample is near to its middle.
struct Temporal {
  static constexpr VkFormat kHistoryFormat = VK_FORMAT_R16G16B16A16_SFLOAT;  // display values: a mean of 32 frames needs more than 8 bits

  const Device& device;
  Handle<VkSampler> sampler, texel_sampler;
  Handle<VkDescriptorSetLayout> set_layout;
  Handle<VkPipelineLayout> pipeline_layout;
  Handle<VkDescriptorPool> descriptor_pool;
  Handle<VkPipeline> pipeline, enlarging_pipeline;
  std::array<VkDescriptorSet, 2> sets = {};  ///< [i] reads history[1 - i]

  std::array<Image, 2> history;  ///< read and written in turn
  std::size_t written = 0;       ///< index of the history that the latest frame wrote
  VkExtent2D written_to = {};    ///< what of that image

  std::uint32_t frame = 0;                   ///< since the start
  float averaged = 0;                        ///< frames in the history; 0: nothing is
  bool moving = false;                       ///< the latest frame differs from the one before
  glm::mat4 clip_from_world = glm::mat4(1);  ///< the latest frame's, without jitter
  glm::vec2 moved_by = {0, 0};               ///< how it was moved, clip space

  /// blended_format  of the image record_temporal writes
  /// velocity        there is such an image; without, nothing but the camera moves
  Temporal(const Device& device, VkFormat blended_format, bool velocity);
};

/// Replaces the history. `toned`, `depth` and `velocity`, all with VK_IMAGE_USAGE_SAMPLED_BIT, are what record_temporal will read, as large
/// as the picture. No frame may be in flight.
void resize_temporal(Temporal& temporal, const Image& toned, const Image& depth, const Image& velocity);

/// By how much to move the next frame, px of it, each within half a pixel: 64 points that cover the pixel evenly, and so do 16 of them in a
/// row.
glm::vec2 temporal_jitter_px(const Temporal& temporal);

struct TemporalView {
  glm::mat4 clip_from_world;     ///< not moved
  glm::vec2 jitter_px = {0, 0};  ///< the frame's
  VkExtent2D drawn = {};         ///< what of `toned` and `depth` the frame is
  VkExtent2D blends = {};        ///< what of `blended` it is blended to
  bool unchanged = false;        ///< nothing but the camera can have changed since the frame before
};

struct TemporalImages {
  const Image& toned;     ///< this frame alone, display values
  const Image& depth;     ///< left to be read by fragment shaders, as `toned` and `velocity` are
  const Image& velocity;  ///< perhaps none; px since the frame before, jitter included; above 1.5 in z where depth and the cameras say it
  const Image& blended;   ///< written
};
/// Records the blend of a frame into the history and `blended`. All images are in the layout of attachments before.
void record_temporal(Temporal& temporal, VkCommandBuffer commands, const TemporalView& view, const TemporalImages& images);

}  // namespace forest
