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

/// Shader modules for the time their pipelines are created.
struct Modules {
  Device& device;
  std::array<VkShaderModule, 9> modules{};

  ~Modules() {
    for (VkShaderModule module : modules) device.vk.vkDestroyShaderModule(device.device, module, nullptr);
  }
  Result<void> create(std::size_t index, std::span<const std::uint32_t> words) {
    const VkShaderModuleCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = words.size_bytes(), .pCode = words.data()};
    COPPICE_CHECK(check_created(device, device.vk.vkCreateShaderModule(device.device, &info, nullptr, &modules[index]),
                                "vkCreateShaderModule", modules[index]));
    return {};
  }
};

VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits stage_bit, VkShaderModule module,
                                      const VkSpecializationInfo* constants = nullptr) {
  return {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
          .stage = stage_bit,
          .module = module,
          .pName = "main",
          .pSpecializationInfo = constants};
}

Result<VkPipeline> create_cull_pipeline(Device& device, VkPipelineCache cache, VkPipelineLayout layout, VkShaderModule module,
                                        std::uint32_t debugged) {
  const VkSpecializationMapEntry entry{.constantID = 0, .offset = 0, .size = sizeof debugged};
  const VkSpecializationInfo constants{.mapEntryCount = 1, .pMapEntries = &entry, .dataSize = sizeof debugged, .pData = &debugged};
  const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                         .stage = stage(VK_SHADER_STAGE_COMPUTE_BIT, module, &constants),
                                         .layout = layout};
  VkPipeline pipeline = VK_NULL_HANDLE;
  COPPICE_CHECK(
      check(device, device.vk.vkCreateComputePipelines(device.device, cache, 1, &info, nullptr, &pipeline), "vkCreateComputePipelines"));
  return pipeline;
}

}  // namespace

AttachmentDesc shadow_attachments(const AttachmentDesc& attachments) {
  return {.depth_format = attachments.shadow_format, .depth_compare = attachments.depth_compare};
}

Result<VkPipeline> create_draw_pipeline(Device& device, const AttachmentDesc& attachments, VkPipelineCache cache, VkPipelineLayout layout,
                                        const DrawShaders& shaders) {
  const std::uint32_t color_count = attachments.color_format != VK_FORMAT_UNDEFINED ? 1 : 0;
  const std::array entries{VkSpecializationMapEntry{.constantID = 0, .offset = 0, .size = sizeof(std::uint32_t)},
                           VkSpecializationMapEntry{.constantID = 1, .offset = sizeof(std::uint32_t), .size = sizeof(std::uint32_t)}};
  const VkSpecializationInfo constants{.mapEntryCount = entries.size(),
                                       .pMapEntries = entries.data(),
                                       .dataSize = sizeof shaders.constants,
                                       .pData = shaders.constants.data()};
  const std::array stages{stage(VK_SHADER_STAGE_VERTEX_BIT, shaders.vertex),
                          stage(VK_SHADER_STAGE_FRAGMENT_BIT, shaders.fragment, &constants)};
  const VkPipelineVertexInputStateCreateInfo vertex_input{.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const VkPipelineInputAssemblyStateCreateInfo assembly{.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo raster{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .cullMode = VK_CULL_MODE_NONE, .lineWidth = 1.0f};
  const VkPipelineMultisampleStateCreateInfo samples{.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                     .rasterizationSamples = attachments.samples};
  const VkPipelineDepthStencilStateCreateInfo depth{.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                    .depthTestEnable = VK_TRUE,
                                                    .depthWriteEnable = VK_TRUE,
                                                    .depthCompareOp = attachments.depth_compare};
  const VkPipelineColorBlendAttachmentState no_blend{.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                                                                       VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
  const VkPipelineColorBlendStateCreateInfo blend{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO, .attachmentCount = color_count, .pAttachments = &no_blend};
  const std::array dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic{.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                 .dynamicStateCount = static_cast<std::uint32_t>(dynamic_states.size()),
                                                 .pDynamicStates = dynamic_states.data()};
  const VkPipelineRenderingCreateInfo rendering{.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                .colorAttachmentCount = color_count,
                                                .pColorAttachmentFormats = &attachments.color_format,
                                                .depthAttachmentFormat = attachments.depth_format};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = &rendering,
                                          .stageCount = static_cast<std::uint32_t>(stages.size()),
                                          .pStages = stages.data(),
                                          .pVertexInputState = &vertex_input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport,
                                          .pRasterizationState = &raster,
                                          .pMultisampleState = &samples,
                                          .pDepthStencilState = &depth,
                                          .pColorBlendState = &blend,
                                          .pDynamicState = &dynamic,
                                          .layout = layout};
  VkPipeline pipeline = VK_NULL_HANDLE;
  COPPICE_CHECK(
      check(device, device.vk.vkCreateGraphicsPipelines(device.device, cache, 1, &info, nullptr, &pipeline), "vkCreateGraphicsPipelines"));
  return pipeline;
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

Result<void> create_passes(Device& device, const AttachmentDesc& attachments, VkPipelineCache cache, Passes& passes) {
  COPPICE_CHECK(create_layouts(device, passes));
  COPPICE_CHECK(create_samplers(device, passes));
  Modules modules{device};
  COPPICE_CHECK(modules.create(0, cull_comp_spirv));
  COPPICE_CHECK(modules.create(1, leaf_vert_spirv));
  COPPICE_CHECK(modules.create(2, wood_vert_spirv));
  COPPICE_CHECK(modules.create(3, plant_frag_spirv));
  COPPICE_CHECK(modules.create(4, leaf_mesh_vert_spirv));
  for (std::uint32_t debugged = 0; debugged < passes.cull.size(); ++debugged) {
    COPPICE_TRY(cull, create_cull_pipeline(device, cache, passes.layout, modules.modules[0], debugged));
    passes.cull[debugged] = cull;
  }
  COPPICE_CHECK(modules.create(5, relief_frag_spirv));
  COPPICE_CHECK(modules.create(6, wood_relief_vert_spirv));
  COPPICE_CHECK(modules.create(7, leaf_mesh_relief_vert_spirv));
  struct Wanted {
    std::array<VkPipeline, 2>* pipelines;
    std::size_t vertex, fragment;
    std::uint32_t leaf;  ///< kLeaf of plant.frag and relief.frag
  };
  for (const Wanted& wanted :
       {Wanted{&passes.camera.leaf, 1, 3, 1}, Wanted{&passes.camera.wood.plain, 2, 3, 0}, Wanted{&passes.camera.wood.relief, 6, 5, 0},
        Wanted{&passes.camera.leaf_mesh.plain, 4, 3, 1}, Wanted{&passes.camera.leaf_mesh.relief, 7, 5, 1}})
    for (const std::uint32_t textured : {0u, 1u}) {
      const DrawShaders shaders{modules.modules[wanted.vertex], modules.modules[wanted.fragment], {textured, wanted.leaf}};
      COPPICE_TRY(pipeline, create_draw_pipeline(device, attachments, cache, passes.layout, shaders));
      (*wanted.pipelines)[textured] = pipeline;
    }
  if (attachments.shadow_format == VK_FORMAT_UNDEFINED) return {};
  COPPICE_CHECK(modules.create(8, plant_depth_frag_spirv));
  for (const Wanted& wanted : {Wanted{&passes.shadow.leaf, 1, 8, 1}, Wanted{&passes.shadow.wood.plain, 2, 8, 0}})
    for (const std::uint32_t textured : {0u, 1u}) {
      const DrawShaders shaders{modules.modules[wanted.vertex], modules.modules[wanted.fragment], {textured, wanted.leaf}};
      COPPICE_TRY(pipeline, create_draw_pipeline(device, shadow_attachments(attachments), cache, passes.layout, shaders));
      (*wanted.pipelines)[textured] = pipeline;
    }
  return {};
}

void destroy_passes(Device& device, Passes& passes) {
  const Functions& vk = device.vk;
  for (VkPipeline pipeline : passes.cull) vk.vkDestroyPipeline(device.device, pipeline, nullptr);
  for (const DrawPipelines& draw : {passes.camera, passes.shadow})
    for (const auto& pipelines : {draw.leaf, draw.wood.plain, draw.wood.relief, draw.leaf_mesh.plain, draw.leaf_mesh.relief})
      for (VkPipeline pipeline : pipelines) vk.vkDestroyPipeline(device.device, pipeline, nullptr);
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
