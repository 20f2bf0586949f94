#include "pipelines.h"

#include <array>
#include <vector>

#include "failure.h"
#include "vk_struct.h"

namespace forest {
namespace {

Handle<VkShaderModule> create_module(const Device& device, std::span<const std::uint32_t> spirv) {
  VkShaderModuleCreateInfo info = vk_struct<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  info.codeSize = spirv.size_bytes();
  info.pCode = spirv.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(device.handle, &info, nullptr, &module), "vkCreateShaderModule");
  return {device.handle, module, vkDestroyShaderModule};
}

VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits which, VkShaderModule module, const VkSpecializationInfo* constants = nullptr) {
  VkPipelineShaderStageCreateInfo info = vk_struct<VkPipelineShaderStageCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO);
  info.stage = which;
  info.module = module;
  info.pName = "main";
  info.pSpecializationInfo = constants;
  return info;
}

/// The fixed-function state of every pipeline here; its structs point at each other, so it stays where it is built.
struct FixedState {
  VkPipelineVertexInputStateCreateInfo vertex_input =
      vk_struct<VkPipelineVertexInputStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO);
  VkPipelineInputAssemblyStateCreateInfo assembly =
      vk_struct<VkPipelineInputAssemblyStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO);
  VkPipelineViewportStateCreateInfo viewport =
      vk_struct<VkPipelineViewportStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO);
  VkPipelineRasterizationStateCreateInfo raster =
      vk_struct<VkPipelineRasterizationStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO);
  VkPipelineMultisampleStateCreateInfo multisample =
      vk_struct<VkPipelineMultisampleStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO);
  VkPipelineDepthStencilStateCreateInfo depth =
      vk_struct<VkPipelineDepthStencilStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO);
  std::array<VkPipelineColorBlendAttachmentState, 2> attachments{};
  std::array<VkFormat, 2> color_formats{};
  VkPipelineColorBlendStateCreateInfo blend =
      vk_struct<VkPipelineColorBlendStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO);
  std::array<VkDynamicState, 2> dynamic_states = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic =
      vk_struct<VkPipelineDynamicStateCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO);
  VkPipelineRenderingCreateInfo rendering = vk_struct<VkPipelineRenderingCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO);

  explicit FixedState(const PipelineDesc& desc) {
    vertex_input.vertexBindingDescriptionCount = static_cast<std::uint32_t>(desc.bindings.size());
    vertex_input.pVertexBindingDescriptions = desc.bindings.data();
    vertex_input.vertexAttributeDescriptionCount = static_cast<std::uint32_t>(desc.attributes.size());
    vertex_input.pVertexAttributeDescriptions = desc.attributes.data();
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    viewport.viewportCount = 1;
    viewport.scissorCount = 1;
    raster.lineWidth = 1;
    multisample.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    depth.depthTestEnable = desc.depth_format != VK_FORMAT_UNDEFINED;
    depth.depthWriteEnable = depth.depthTestEnable && desc.depth_write;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER_OR_EQUAL;
    set_blend(desc.alpha_blend);
    dynamic.dynamicStateCount = static_cast<std::uint32_t>(dynamic_states.size());
    dynamic.pDynamicStates = dynamic_states.data();
    color_formats = {desc.color_format, desc.second_color_format};
    rendering.colorAttachmentCount = blend.attachmentCount = desc.second_color_format != VK_FORMAT_UNDEFINED ? 2 : 1;
    rendering.pColorAttachmentFormats = color_formats.data();
    rendering.depthAttachmentFormat = desc.depth_format;
  }
  FixedState(const FixedState&) = delete;
  FixedState& operator=(const FixedState&) = delete;

  void set_blend(bool alpha_blend) {
    for (VkPipelineColorBlendAttachmentState& attachment : attachments) {
      attachment.blendEnable = alpha_blend;
      attachment.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA;
      attachment.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
      attachment.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
      attachment.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
      attachment.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    }
    blend.pAttachments = attachments.data();
  }
};

}  // namespace

Handle<VkPipeline> create_pipeline(const Device& device, const PipelineDesc& desc) {
  const Handle<VkShaderModule> vertex = create_module(device, desc.vertex_spirv);
  const Handle<VkShaderModule> fragment = create_module(device, desc.fragment_spirv);
  const VkSpecializationMapEntry entry{0, 0, sizeof desc.fragment_constant};
  const VkSpecializationInfo constants{1, &entry, sizeof desc.fragment_constant, &desc.fragment_constant};
  const std::array stages = {stage(VK_SHADER_STAGE_VERTEX_BIT, vertex), stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment, &constants)};
  const FixedState fixed(desc);
  VkGraphicsPipelineCreateInfo info = vk_struct<VkGraphicsPipelineCreateInfo>(VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO);
  info.pNext = &fixed.rendering;
  info.stageCount = static_cast<std::uint32_t>(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &fixed.vertex_input;
  info.pInputAssemblyState = &fixed.assembly;
  info.pViewportState = &fixed.viewport;
  info.pRasterizationState = &fixed.raster;
  info.pMultisampleState = &fixed.multisample;
  info.pDepthStencilState = &fixed.depth;
  info.pColorBlendState = &fixed.blend;
  info.pDynamicState = &fixed.dynamic;
  info.layout = desc.layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateGraphicsPipelines(device.handle, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), "vkCreateGraphicsPipelines");
  return {device.handle, pipeline, vkDestroyPipeline};
}

Handle<VkPipelineLayout> create_pipeline_layout(const Device& device, VkDescriptorSetLayout set, std::uint32_t push_bytes,
                                                VkShaderStageFlags push_stages) {
  const VkPushConstantRange range{push_stages, 0, push_bytes};
  VkPipelineLayoutCreateInfo info = vk_struct<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  info.setLayoutCount = 1;
  info.pSetLayouts = &set;
  info.pushConstantRangeCount = push_bytes ? 1 : 0;
  info.pPushConstantRanges = &range;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  check(vkCreatePipelineLayout(device.handle, &info, nullptr, &layout), "vkCreatePipelineLayout");
  return {device.handle, layout, vkDestroyPipelineLayout};
}

Handle<VkDescriptorSetLayout> create_set_layout(const Device& device, std::span<const VkDescriptorType> types) {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (VkDescriptorType type : types)
    bindings.push_back(
        {static_cast<std::uint32_t>(bindings.size()), type, 1, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, nullptr});
  VkDescriptorSetLayoutCreateInfo info = vk_struct<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  info.bindingCount = static_cast<std::uint32_t>(bindings.size());
  info.pBindings = bindings.data();
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  check(vkCreateDescriptorSetLayout(device.handle, &info, nullptr, &layout), "vkCreateDescriptorSetLayout");
  return {device.handle, layout, vkDestroyDescriptorSetLayout};
}

Handle<VkSampler> create_sampler(const Device& device, VkSamplerAddressMode address_mode, VkFilter filter) {
  VkSamplerCreateInfo info = vk_struct<VkSamplerCreateInfo>(VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO);
  info.magFilter = filter;
  info.minFilter = filter;
  // Where a processor samples, a second mip costs as much as the first.
  info.mipmapMode = device.software || filter == VK_FILTER_NEAREST ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
  info.addressModeU = address_mode;
  info.addressModeV = address_mode;
  info.addressModeW = address_mode;
  info.maxLod = VK_LOD_CLAMP_NONE;
  VkSampler sampler = VK_NULL_HANDLE;
  check(vkCreateSampler(device.handle, &info, nullptr, &sampler), "vkCreateSampler");
  return {device.handle, sampler, vkDestroySampler};
}

void record_viewport(VkCommandBuffer commands, VkExtent2D extent, VkOffset2D first) {
  const VkViewport viewport{
      static_cast<float>(first.x), static_cast<float>(first.y), static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
  const VkRect2D scissor{first, extent};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &scissor);
}

}  // namespace forest
