#pragma once

#include <array>
#include <cstdint>

#include "device.h"
#include "result.h"

namespace coppice::gpu {

/// The attachments record_draw will find.
struct AttachmentDesc {
  VkFormat color_format = VK_FORMAT_UNDEFINED;
  VkFormat depth_format = VK_FORMAT_UNDEFINED;
  VkCompareOp depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
};

/// Everything that is created once: layouts, sampler, pipelines.
struct Passes {
  VkDescriptorSetLayout frame_set_layout = VK_NULL_HANDLE;    ///< set 0, the bindings of bindings.glsl and cull.comp
  VkDescriptorSetLayout texture_set_layout = VK_NULL_HANDLE;  ///< set 1, one base colour texture
  VkSampler sampler = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;  ///< both sets and DrawPush; the cull pipeline uses set 0 of it
  VkPipeline cull = VK_NULL_HANDLE;
  std::array<VkPipeline, 2> leaf{};       ///< [textured]
  std::array<VkPipeline, 2> wood{};       ///< [textured]
  std::array<VkPipeline, 2> leaf_mesh{};  ///< [textured]
};

inline constexpr std::uint32_t kFrameBindingCount = 10;

/// errors  out_of_memory; internal: the driver refuses a pipeline. What was created so far is in `passes`, to be destroyed in any case
Result<void> create_passes(Device& device, const AttachmentDesc& attachments, VkPipelineCache cache, Passes& passes);
void destroy_passes(Device& device, Passes& passes);

/// kKind of plant.frag.
enum class FragmentKind : std::uint32_t { plain = 0, textured = 1 };

struct DrawShaders {
  VkShaderModule vertex, fragment;
  FragmentKind kind;
};

/// Triangles on the attachments, depth tested and written; viewport and scissor are dynamic. errors  out_of_memory, internal
Result<VkPipeline> create_draw_pipeline(Device& device, const AttachmentDesc& attachments, VkPipelineCache cache, VkPipelineLayout layout,
                                        const DrawShaders& shaders);

struct DescriptorSet {
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
};

/// A pool with one set 0, written. buffers: in binding order
Result<DescriptorSet> create_frame_set(Device& device, const Passes& passes, const std::array<VkBuffer, kFrameBindingCount>& buffers);
/// A pool with one set 1, written.
Result<DescriptorSet> create_texture_set(Device& device, const Passes& passes, VkImageView view);

}  // namespace coppice::gpu
