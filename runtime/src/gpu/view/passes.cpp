#include "passes.h"

#include <algorithm>
#include <span>

#include "coppice_shared.h"
#include "cull_comp.h"
#include "leaf_depth_frag.h"
#include "leaf_frag.h"
#include "leaf_mesh_relief_vert.h"
#include "leaf_mesh_vert.h"
#include "leaf_vert.h"
#include "plant_depth_frag.h"
#include "plant_frag.h"
#include "relief_frag.h"
#include "wood_relief_vert.h"
#include "wood_vert.h"

namespace coppice::gpu {
namespace {

constexpr VkShaderStageFlags kAllStages = VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

/// The view is a uniform buffer, the tables are texels, all else storage buffers. From leaf commands on only the passes that cull see them:
/// few devices promise ten storage buffers to each stage.
constexpr std::array<Binding, kFrameBuffers + 1> kFrameSet = [] {
  std::array<Binding, kFrameBuffers + 1> bindings{};
  for (std::uint32_t i = 0; i < kFrameBuffers; ++i)
    bindings[i].stages =
        i < static_cast<std::uint32_t>(FrameBinding::leaf_commands) ? kAllStages : VkShaderStageFlags{VK_SHADER_STAGE_COMPUTE_BIT};
  bindings[static_cast<std::uint32_t>(FrameBinding::view)].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  bindings[static_cast<std::uint32_t>(FrameBinding::tables)].type = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  bindings[kFrameBuffers] = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kAllStages, kMaxCascades};
  return bindings;
}();

Result<void> create_layouts(Device& device, const TextureSets& textures, Passes& passes) {
  COPPICE_CHECK(move_into(passes.frame_set, create_set_layout(device, kFrameSet)));
  const VkSamplerCreateInfo sampler{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                    .magFilter = VK_FILTER_NEAREST,
                                    .minFilter = VK_FILTER_NEAREST,
                                    .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                    .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                    .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                    .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                    .maxLod = VK_LOD_CLAMP_NONE};
  COPPICE_CHECK(check_created(device, device.vk.vkCreateSampler(device.device, &sampler, nullptr, &passes.map_sampler), "vkCreateSampler",
                              passes.map_sampler));
  const std::array sets{passes.frame_set.layout, textures.layout(), textures.layout()};
  const VkPushConstantRange push{.stageFlags = VK_SHADER_STAGE_VERTEX_BIT, .size = sizeof(DrawPush)};
  return move_into(passes.layout, create_pipeline_layout(device, sets, push));
}

using Words = std::span<const std::uint32_t>;

struct Drawn {
  const char* name;
  Words vertex, fragment;
  std::uint32_t leaf;  ///< kLeaf of surface_in.glsl
};

}  // namespace

Result<void> create_passes(Device& device, const AttachmentDesc& attachments, const TextureSets& textures, PipelineSet& pipelines,
                           Passes& passes) {
  COPPICE_CHECK(create_layouts(device, textures, passes));
  const auto add_cull = [&](std::uint32_t debugged) {
    return &pipelines.add({.name = "cull.comp", .layout = passes.layout, .first = Words(cull_comp_spirv), .constants = {debugged}});
  };
  passes.cull = {add_cull(0), add_cull(1)};
  const auto add_one = [&](const Drawn& drawn, const AttachmentDesc& on, std::uint32_t textured, std::uint32_t gaps) {
    return &pipelines.add({.name = drawn.name,
                           .layout = passes.layout,
                           .first = drawn.vertex,
                           .fragment = drawn.fragment,
                           .constants = {textured, drawn.leaf, gaps},
                           .attachments = on});
  };
  const auto add = [&](const Drawn& drawn, const AttachmentDesc& on) {
    return SurfacePipelines{add_one(drawn, on, 0, 0), add_one(drawn, on, 1, 0)};
  };
  // A texture's holes are discarded in any case.
  const auto add_quads = [&](const Drawn& drawn, const AttachmentDesc& on) {
    return LeafPipelines{{add_one(drawn, on, 0, 0), add_one(drawn, on, 1, 1)}, add_one(drawn, on, 0, 1)};
  };
  DrawPipelines& camera = passes.camera;
  camera.leaf = add_quads({"leaf.vert", leaf_vert_spirv, leaf_frag_spirv, 1}, attachments);
  camera.wood.flat = add({"wood.vert", wood_vert_spirv, plant_frag_spirv, 0}, attachments);
  camera.wood.relief = add({"wood.vert, relief.frag", wood_relief_vert_spirv, relief_frag_spirv, 0}, attachments);
  camera.leaf_mesh.flat = add({"leaf_mesh.vert", leaf_mesh_vert_spirv, plant_frag_spirv, 1}, attachments);
  camera.leaf_mesh.relief = add({"leaf_mesh.vert, relief.frag", leaf_mesh_relief_vert_spirv, relief_frag_spirv, 1}, attachments);
  if (attachments.shadow_format == VK_FORMAT_UNDEFINED) return {};
  const AttachmentDesc depth = shadow_attachments(attachments);
  passes.shadow.leaf = add_quads({"leaf.vert of shadow views", leaf_vert_spirv, leaf_depth_frag_spirv, 1}, depth);
  passes.shadow.wood.flat = add({"wood.vert of shadow views", wood_vert_spirv, plant_depth_frag_spirv, 0}, depth);
  return {};
}

void destroy_passes(Device& device, Passes& passes) {
  device.vk.vkDestroyPipelineLayout(device.device, passes.layout, nullptr);
  device.vk.vkDestroySampler(device.device, passes.map_sampler, nullptr);
  destroy_set_layout(device, passes.frame_set);
  passes = {};
}

Result<DescriptorSet> create_frame_set(Device& device, const Passes& passes, const FrameBindings& bindings) {
  std::array<Bound, kFrameBuffers + 1> bound{};
  for (std::size_t i = 0; i < kFrameBuffers; ++i) bound[i].buffer = bindings.buffers[i];
  bound[kFrameBuffers] = {.sampler = passes.map_sampler, .views = bindings.maps.data()};
  return create_set(device, passes.frame_set, bound);
}

}  // namespace coppice::gpu
