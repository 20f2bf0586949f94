#pragma once

#include <array>
#include <memory>
#include <string>

#include "frames.h"
#include "options.h"
#include "resources.h"
#include "statistics.h"
#include "window.h"

namespace forest {

/// What the sliders hold.
struct Controls {
  float error_px = 2;
  float wind_mps = 0;
  float frame_ms = 0;  ///< aim; 0: none
  int memory_mb = 256;
  LodMode lod = LodMode::cut;
  DebugView view = DebugView::none;
};

/// ImGui in the window. Its own Vulkan backend calls exported vk* functions and wants a render pass, so the hundred lines that draw its
/// triangles are here.
struct Overlay {
  const Device& device;
  Image font;
  Handle<VkSampler> sampler;
  Handle<VkDescriptorSetLayout> set_layout;
  Handle<VkPipelineLayout> pipeline_layout;
  Handle<VkDescriptorPool> descriptor_pool;
  VkDescriptorSet set = VK_NULL_HANDLE;
  Handle<VkPipeline> pipeline;
  std::array<Buffer, FrameRing::kSlots> geometry;  ///< vertices, then indices; grows as needed
  std::array<float, 120> frame_ms = {};            ///< a ring
  std::size_t frame_count = 0;                     ///< that went into it
  std::uint64_t bytes_read = 0;                    ///< as of the frame before
  double decode_ms = 0;                            ///< likewise
  float bytes_per_ms = 0, decode_share = 0;        ///< recent values; decode_share in threads
  bool hidden = false;                             ///< whatever the window asks for: for pictures that are saved
  std::string message;                             ///< what has just been done
  float message_left_ms = 0;                       ///< for so long it is shown

  /// color_format  of the attachment record_overlay draws to
  Overlay(const Device& device, const Window& window, VkFormat color_format);
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;
  ~Overlay();
};

/// What the panel shows.
struct OverlayFigures {
  const coppice_stats& stats;
  const coppice_view_stats& view;
  const SceneTimes* scene_times;  ///< null where passes are not measured
  float frame_ms = 0;
  VkExtent2D drawn = {};  ///< drawn size of the picture
  float leaf_budget = 0;  ///< 0: none
};

/// Shows a line at the picture's lower edge for some seconds.
void show_message(Overlay& overlay, std::string text);

/// Lays out this frame's panels, of which none reaches beyond the window, and reads the sliders into `controls`.
void layout_overlay(Overlay& overlay, const Window& window, const OverlayFigures& figures, Controls& controls);
/// Draws what layout_overlay laid out. Inside rendering; binds its own pipeline.
void record_overlay(Overlay& overlay, VkCommandBuffer commands, std::size_t slot, VkExtent2D extent);
/// Whether the pointer is on the panel.
bool overlay_uses_mouse();

}  // namespace forest
