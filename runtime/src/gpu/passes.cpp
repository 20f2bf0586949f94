#include "passes.h"

#include <span>

#include "coppice_shared.h"
#include "cull_comp.h"
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

Result<VkDescriptorSetLayout> create_set_layout(Device& device, std::span<const VkDescriptorSetLayoutBinding> bindings) {
  const VkDescriptorSetLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                             .bindingCount = static_cast<std::uint32_t>(bindings.size()),
                                             .pBindings = bindings.data()};
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  COPPICE_CHECK(
      check(device, device.vk.vkCreateDescriptorSetLayout(device.device, &info, nullptr, &layout), "vkCreateDescriptorSetLayout"));
  return layout;
}

/// From this binding of the frame set on only the cull pass sees them: few devices promise ten storage buffers to each stage.
constexpr std::uint32_t kFirstCullBinding = 6;
constexpr VkShaderStageFlags kAllStages = VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

/// The view is a uniform buffer, the tables are texels, all else storage buffers.
constexpr std::uint32_t kViewBinding = 0, kTableBinding = 3;
VkDescriptorType frame_binding_type(std::uint32_t binding) {
  if (binding == kViewBinding) return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  return binding == kTableBinding ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

Result<void> create_layouts(Device& device, Passes& passes) {
  std::array<VkDescriptorSetLayoutBinding, kFrameBindingCount + 1> frame{};
  for (std::uint32_t i = 0; i < kFrameBindingCount; ++i)
    frame[i] = {.binding = i,
                .descriptorType = frame_binding_type(i),
                .descriptorCount = 1,
                .stageFlags = i < kFirstCullBinding ? kAllStages : VkShaderStageFlags{VK_SHADER_STAGE_COMPUTE_BIT}};
  frame[kFrameBindingCount] = {.binding = kFrameBindingCount,
                               .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                               .descriptorCount = kMaxCascades,
                               .stageFlags = kAllStages};
  COPPICE_TRY(frame_layout, create_set_layout(device, frame));
  passes.frame_set_layout = frame_layout;
  const VkDescriptorSetLayoutBinding texture{
      .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, .descriptorCount = 1, .stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT};
  COPPICE_TRY(texture_layout, create_set_layout(device, std::span(&texture, 1)));
  passes.texture_set_layout = texture_layout;

  const std::array sets{passes.frame_set_layout, passes.texture_set_layout, passes.texture_set_layout};
  const VkPushConstantRange push{.stageFlags = VK_SHADER_STAGE_VERTEX_BIT, .size = sizeof(DrawPush)};
  const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                        .setLayoutCount = static_cast<std::uint32_t>(sets.size()),
                                        .pSetLayouts = sets.data(),
                                        .pushConstantRangeCount = 1,
                                        .pPushConstantRanges = &push};
  COPPICE_CHECK(check_created(device, device.vk.vkCreatePipelineLayout(device.device, &info, nullptr, &passes.layout),
                              "vkCreatePipelineLayout", passes.layout));
  return {};
}

/// Where a processor does the GPU's work, mip levels do not blend: a second level's texels double what a fragment costs.
VkSamplerMipmapMode mipmap_mode(const Device& device) {
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  device.vk.vkGetPhysicalDeviceProperties2(device.physical_device, &properties);
  const bool software = properties.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  return software ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
}

Result<void> create_samplers(Device& device, Passes& passes) {
  VkSamplerCreateInfo info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                           .magFilter = VK_FILTER_LINEAR,
                           .minFilter = VK_FILTER_LINEAR,
                           .mipmapMode = mipmap_mode(device),
                           .maxLod = VK_LOD_CLAMP_NONE};
  COPPICE_CHECK(
      check_created(device, device.vk.vkCreateSampler(device.device, &info, nullptr, &passes.sampler), "vkCreateSampler", passes.sampler));
  info.magFilter = info.minFilter = VK_FILTER_NEAREST;
  info.mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST;
  info.addressModeU = info.addressModeV = info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  COPPICE_CHECK(check_created(device, device.vk.vkCreateSampler(device.device, &info, nullptr, &passes.map_sampler), "vkCreateSampler",
                              passes.map_sampler));
  return {};
}

}  // namespace

AttachmentDesc shadow_attachments(const AttachmentDesc& attachments) {
  return {.depth_format = attachments.shadow_format, .depth_compare = attachments.depth_compare};
}

namespace {

Result<DescriptorSet> allocate_set(Device& device, VkDescriptorSetLayout layout, std::span<const VkDescriptorPoolSize> sizes) {
  const VkDescriptorPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = static_cast<std::uint32_t>(sizes.size()),
                                             .pPoolSizes = sizes.data()};
  DescriptorSet allocated;
  COPPICE_CHECK(
      check(device, device.vk.vkCreateDescriptorPool(device.device, &pool_info, nullptr, &allocated.pool), "vkCreateDescriptorPool"));
  const VkDescriptorSetAllocateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = allocated.pool,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &layout};
  auto set = check(device, device.vk.vkAllocateDescriptorSets(device.device, &set_info, &allocated.set), "vkAllocateDescriptorSets");
  if (!set) {
    device.vk.vkDestroyDescriptorPool(device.device, allocated.pool, nullptr);
    return set.error();
  }
  return allocated;
}

}  // namespace

Result<void> create_passes(Device& device, const AttachmentDesc& attachments, PipelineSet& pipelines, Passes& passes) {
  COPPICE_CHECK(create_layouts(device, passes));
  COPPICE_CHECK(create_samplers(device, passes));
  using Words = std::span<const std::uint32_t>;
  struct Drawn {
    const char* name;
    Words vertex, fragment;
    std::uint32_t leaf;  ///< kLeaf of plant.frag and relief.frag
  };
  const auto add = [&](const Drawn& drawn, const AttachmentDesc& on) {
    std::array<Pipeline*, 2> added{};
    for (const std::uint32_t textured : {0u, 1u})
      added[textured] = &pipelines.add({.name = drawn.name,
                                        .layout = passes.layout,
                                        .first = drawn.vertex,
                                        .fragment = drawn.fragment,
                                        .constants = {textured, drawn.leaf},
                                        .attachments = on});
    return added;
  };
  for (const std::uint32_t debugged : {0u, 1u})
    passes.cull[debugged] =
        &pipelines.add({.name = "cull.comp", .layout = passes.layout, .first = Words(cull_comp_spirv), .constants = {debugged}});
  DrawPipelines& camera = passes.camera;
  camera.leaf = add({"leaf.vert", leaf_vert_spirv, plant_frag_spirv, 1}, attachments);
  camera.wood.plain = add({"wood.vert", wood_vert_spirv, plant_frag_spirv, 0}, attachments);
  camera.wood.relief = add({"wood.vert, relief.frag", wood_relief_vert_spirv, relief_frag_spirv, 0}, attachments);
  camera.leaf_mesh.plain = add({"leaf_mesh.vert", leaf_mesh_vert_spirv, plant_frag_spirv, 1}, attachments);
  camera.leaf_mesh.relief = add({"leaf_mesh.vert, relief.frag", leaf_mesh_relief_vert_spirv, relief_frag_spirv, 1}, attachments);
  if (attachments.shadow_format == VK_FORMAT_UNDEFINED) return {};
  const AttachmentDesc depth = shadow_attachments(attachments);
  passes.shadow.leaf = add({"leaf.vert of shadow views", leaf_vert_spirv, plant_depth_frag_spirv, 1}, depth);
  passes.shadow.wood.plain = add({"wood.vert of shadow views", wood_vert_spirv, plant_depth_frag_spirv, 0}, depth);
  return {};
}

void destroy_passes(Device& device, Passes& passes) {
  const Functions& vk = device.vk;
  vk.vkDestroyPipelineLayout(device.device, passes.layout, nullptr);
  vk.vkDestroySampler(device.device, passes.sampler, nullptr);
  vk.vkDestroySampler(device.device, passes.map_sampler, nullptr);
  vk.vkDestroyDescriptorSetLayout(device.device, passes.frame_set_layout, nullptr);
  vk.vkDestroyDescriptorSetLayout(device.device, passes.texture_set_layout, nullptr);
  passes = {};
}

Result<DescriptorSet> create_frame_set(Device& device, const Passes& passes, const FrameBindings& bindings) {
  constexpr std::array<VkDescriptorPoolSize, 4> kSizes{{{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1},
                                                        {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 1},
                                                        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, kFrameBindingCount - 2},
                                                        {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kMaxCascades}}};
  COPPICE_TRY(allocated, allocate_set(device, passes.frame_set_layout, kSizes));
  std::array<VkDescriptorBufferInfo, kFrameBindingCount> infos{};
  std::array<VkDescriptorImageInfo, kMaxCascades> maps{};
  std::array<VkWriteDescriptorSet, kFrameBindingCount + 1> writes{};
  for (std::uint32_t i = 0; i < kFrameBindingCount; ++i) {
    infos[i] = {.buffer = bindings.buffers[i]->buffer, .range = VK_WHOLE_SIZE};
    writes[i] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                 .dstSet = allocated.set,
                 .dstBinding = i,
                 .descriptorCount = 1,
                 .descriptorType = frame_binding_type(i),
                 .pBufferInfo = &infos[i],
                 .pTexelBufferView = &bindings.buffers[i]->texels};
  }
  for (std::size_t i = 0; i < maps.size(); ++i) maps[i] = {passes.map_sampler, bindings.maps[i], VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  writes[kFrameBindingCount] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                .dstSet = allocated.set,
                                .dstBinding = kFrameBindingCount,
                                .descriptorCount = kMaxCascades,
                                .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                .pImageInfo = maps.data()};
  device.vk.vkUpdateDescriptorSets(device.device, static_cast<std::uint32_t>(writes.size()), writes.data(), 0, nullptr);
  return allocated;
}

Result<DescriptorSet> create_texture_set(Device& device, const Passes& passes, VkImageView view) {
  constexpr VkDescriptorPoolSize kSize{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
  COPPICE_TRY(allocated, allocate_set(device, passes.texture_set_layout, std::span(&kSize, 1)));
  const VkDescriptorImageInfo info{passes.sampler, view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = allocated.set,
                                   .descriptorCount = 1,
                                   .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                   .pImageInfo = &info};
  device.vk.vkUpdateDescriptorSets(device.device, 1, &write, 0, nullptr);
  return allocated;
}

}  // namespace coppice::gpu
