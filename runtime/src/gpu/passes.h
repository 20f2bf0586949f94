#pragma once

#include <array>
#include <cstdint>

#include "coppice_shared.h"
#include "device.h"
#include "pipelines.h"
#include "result.h"

namespace coppice::gpu {

/// Whether what is nearer has the larger depth.
constexpr bool is_reversed(VkCompareOp compare) {
  return compare == VK_COMPARE_OP_GREATER || compare == VK_COMPARE_OP_GREATER_OR_EQUAL;
}
/// What a shadow view is drawn to: no colour.
AttachmentDesc shadow_attachments(const AttachmentDesc& attachments);

/// What draws triangles; `relief` with a normal map.
struct MeshPipelines {
  std::array<Pipeline*, 2> plain{}, relief{};  ///< [textured]
};

/// What draws a view.
struct DrawPipelines {
  std::array<Pipeline*, 2> leaf{};  ///< [textured]
  MeshPipelines wood, leaf_mesh;
};

/// Whether pipelines for these attachments can work, by field of coppice_context_desc.
/// errors  invalid_argument: an integer colour format, a depth format without depth; unsupported: this device does not do it
Result<void> check_attachments(const Device& device, const AttachmentDesc& attachments);

/// Everything that is created once: layouts and samplers, and what pipelines there are.
struct Passes {
  VkDescriptorSetLayout frame_set_layout = VK_NULL_HANDLE;    ///< set 0, the bindings of bindings.glsl and cull.comp
  VkDescriptorSetLayout texture_set_layout = VK_NULL_HANDLE;  ///< set 1, the base colour texture, and set 2, the normal map
  VkSampler sampler = VK_NULL_HANDLE;
  VkSampler map_sampler = VK_NULL_HANDLE;    ///< texels of shadow maps as they are
  VkPipelineLayout layout = VK_NULL_HANDLE;  ///< the sets and DrawPush; the cull pipeline uses set 0 of it
  std::array<Pipeline*, 2> cull{};           ///< [with a debug view]
  DrawPipelines camera;
  DrawPipelines shadow;  ///< depth alone, without relief and leaf meshes; null where there are no shadow views
};

inline constexpr std::uint32_t kFrameBindingCount = 10;  ///< buffers; the shadow maps come after them

/// None of the pipelines is wanted yet. errors  out_of_memory, internal. What was created so far is in `passes`, to be destroyed in any
/// case
Result<void> create_passes(Device& device, const AttachmentDesc& attachments, PipelineSet& pipelines, Passes& passes);
/// The pipelines are closed.
void destroy_passes(Device& device, Passes& passes);

struct DescriptorSet {
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
};

/// A pool with one set 0, written.
struct FrameBindings {
  std::array<const Buffer*, kFrameBindingCount> buffers{};  ///< in binding order
  std::array<VkImageView, kMaxCascades> maps{};
};
Result<DescriptorSet> create_frame_set(Device& device, const Passes& passes, const FrameBindings& bindings);
/// A pool with one set 1, written.
Result<DescriptorSet> create_texture_set(Device& device, const Passes& passes, VkImageView view);

}  // namespace coppice::gpu
