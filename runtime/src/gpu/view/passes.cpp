#include "passes.h"

#include <algorithm>
#include <span>
#include <string>

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

/// The view is a uniform buffer, instances and tables are texels, all others are storage buffers. Only the culling shaders see the buffers
/// from leaf commands on, because few devices guarantee ten storage buffers for each stage.
constexpr std::uint32_t kMaps = kFrameBuffers, kOccluders = kMaps + 1, kWind = kOccluders + 1, kMoved = kWind + 1,
                        kFrameBindings = kMoved + 1;
constexpr std::array<Binding, kFrameBindings> kFrameSet = [] {
  std::array<Binding, kFrameBindings> bindings{};
  for (std::uint32_t i = 0; i < kFrameBuffers; ++i)
    bindings[i].stages =
        i < static_cast<std::uint32_t>(FrameBinding::leaf_commands) ? kAllStages : VkShaderStageFlags{VK_SHADER_STAGE_COMPUTE_BIT};
  bindings[static_cast<std::uint32_t>(FrameBinding::view)].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  bindings[static_cast<std::uint32_t>(FrameBinding::tables)].type = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  bindings[static_cast<std::uint32_t>(FrameBinding::instances)].type = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  bindings[kMaps] = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kAllStages, kMaxShadowMaps};
  bindings[kOccluders] = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_COMPUTE_BIT, kMaxEyes};
  bindings[kWind] = bindings[kMoved] = {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, kAllStages};
  return bindings;
}();

Result<void> create_layouts(Device& device, const TextureSets& textures, Passes& passes) {
  COPPICE_CHECK(move_into(passes.frame_set, create_set_layout(device, "coppice frame", kFrameSet)));
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
  const VkPushConstantRange push{.stageFlags = kDrawStages, .size = sizeof(DrawPush)};
  return move_into(passes.layout, create_pipeline_layout(device, sets, push));
}

using Words = std::span<const std::uint32_t>;

struct Drawn {
  const char* name;
  Words vertex, fragment;
  std::uint32_t leaf;  ///< kLeaf of surface_in.glsl
};

}  // namespace

Result<void> create_passes(Device& device, const TextureSets& textures, PipelineSet& pipelines, Passes& passes) {
  if (device.max_stage_buffers < kFrameStorageBuffers)
    return Error{Status::unsupported, "maxPerStageDescriptorStorageBuffers is below 7", Error::kNoOffset,
                 std::to_string(device.max_stage_buffers)};
  static_assert(kFrameStorageBuffers == 7);
  COPPICE_CHECK(create_layouts(device, textures, passes));
  const auto add_cull = [&](std::uint32_t debugged) {
    return for_each_eye_count([&](std::uint32_t eyes) {
      return &pipelines.add(
          {.name = "cull.comp", .layout = passes.layout, .first = Words(cull_comp_spirv), .constants = {debugged, 0, 0, 0, 0, 0, eyes, 0}});
    });
  };
  passes.cull = {add_cull(0), add_cull(1)};
  return {};
}

DrawPipelines add_draw_pipelines(const Passes& passes, const AttachmentDesc& attachments, PipelineSet& pipelines) {
  DrawPipelines draws{.attachments = attachments};
  const auto add = [&](DrawKind kind, const Drawn& drawn, std::uint32_t textured, std::uint32_t transparency) {
    draws.kinds[static_cast<std::size_t>(kind)] =
        &pipelines.add({.name = drawn.name,
                        .layout = passes.layout,
                        .first = drawn.vertex,
                        .fragment = drawn.fragment,
                        .constants = {textured, drawn.leaf, transparency, 0, 0, 0, 0, packed_contents(attachments)},
                        .attachments = attachments});
  };
  const bool depth = is_depth_alone(attachments);
  const Drawn leaf = depth ? Drawn{"leaf.vert of shadow views", leaf_vert_spirv, leaf_depth_frag_spirv, 1}
                           : Drawn{"leaf.vert", leaf_vert_spirv, leaf_frag_spirv, 1};
  add(DrawKind::leaf_plain, leaf, 0, 0);
  add(DrawKind::leaf_textured, leaf, 1, 1);  // holes of a texture are discarded in any case
  add(DrawKind::leaf_plain_transparent, leaf, 0, 1);
  const Drawn wood = depth ? Drawn{"wood.vert of shadow views", wood_vert_spirv, plant_depth_frag_spirv, 0}
                           : Drawn{"wood.vert", wood_vert_spirv, plant_frag_spirv, 0};
  add(DrawKind::wood_plain, wood, 0, 0);
  add(DrawKind::wood_textured, wood, 1, 0);
  if (depth) return draws;
  const Drawn wood_relief{"wood.vert, relief.frag", wood_relief_vert_spirv, relief_frag_spirv, 0};
  add(DrawKind::wood_relief_plain, wood_relief, 0, 0);
  add(DrawKind::wood_relief_textured, wood_relief, 1, 0);
  const Drawn mesh{"leaf_mesh.vert", leaf_mesh_vert_spirv, plant_frag_spirv, 1};
  add(DrawKind::mesh_plain, mesh, 0, 0);
  add(DrawKind::mesh_textured, mesh, 1, 0);
  const Drawn mesh_relief{"leaf_mesh.vert, relief.frag", leaf_mesh_relief_vert_spirv, relief_frag_spirv, 1};
  add(DrawKind::mesh_relief_plain, mesh_relief, 0, 0);
  add(DrawKind::mesh_relief_textured, mesh_relief, 1, 0);
  return draws;
}

void destroy_passes(Device& device, Passes& passes) {
  device.vk.vkDestroyPipelineLayout(device.device, passes.layout, nullptr);
  device.vk.vkDestroySampler(device.device, passes.map_sampler, nullptr);
  destroy_set_layout(device, passes.frame_set);
  passes = {};
}

namespace {

std::array<Bound, kFrameBindings> bound_to(const Passes& passes, const FrameBindings& bindings) {
  std::array<Bound, kFrameBindings> bound{};
  for (std::size_t i = 0; i < kFrameBuffers; ++i) bound[i].buffer = bindings.buffers[i];
  bound[kMaps] = {.sampler = passes.map_sampler, .views = bindings.maps.data()};
  bound[kOccluders] = {.sampler = passes.map_sampler, .views = bindings.occluders.data()};
  bound[kWind].buffer = bindings.wind_maps;
  bound[kMoved].buffer = bindings.moved;
  return bound;
}

}  // namespace

Result<DescriptorSet> create_frame_set(Device& device, const Passes& passes, const FrameBindings& bindings) {
  return create_set(device, passes.frame_set, bound_to(passes, bindings));
}

void write_frame_set(Device& device, const Passes& passes, const DescriptorSet& set, const FrameBindings& bindings) {
  write_set(device, passes.frame_set, set, bound_to(passes, bindings));
}

}  // namespace coppice::gpu
