#include "area_pipelines.h"

#include <span>

#include "leaf_area_frag.h"
#include "leaf_area_vert.h"
#include "whole_view_vert.h"

namespace coppice::bake {
namespace {

struct Shaders {
  VkShaderModule leaf = VK_NULL_HANDLE, holes = VK_NULL_HANDLE, whole_view = VK_NULL_HANDLE;
};

struct PipelineKind {
  VkShaderModule vertex = VK_NULL_HANDLE;
  VkShaderModule fragment = VK_NULL_HANDLE;  ///< may be null
  bool depth_write = false;                  ///< and the test is for nearer; else for equal
};

Result<void> create_module(const AreaDevice& gpu, std::span<const std::uint32_t> words, VkShaderModule& module) {
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = words.size_bytes();
  info.pCode = words.data();
  return check_vulkan(gpu.vk.vkCreateShaderModule(gpu.device, &info, nullptr, &module), "vkCreateShaderModule");
}

Result<void> create_pipeline(const AreaDevice& gpu, VkPipelineLayout layout, const PipelineKind& kind, VkPipeline& pipeline) {
  std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
  stages[0] = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[0].module = kind.vertex;
  stages[0].pName = "main";
  stages[1] = stages[0];
  stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  stages[1].module = kind.fragment;
  const VkPipelineVertexInputStateCreateInfo vertex_input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  raster.cullMode = VK_CULL_MODE_NONE;
  raster.lineWidth = 1.0f;
  VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = VK_TRUE;
  depth.depthWriteEnable = kind.depth_write ? VK_TRUE : VK_FALSE;
  depth.depthCompareOp = kind.depth_write ? VK_COMPARE_OP_LESS : VK_COMPARE_OP_EQUAL;
  const std::array dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = static_cast<std::uint32_t>(dynamic_states.size());
  dynamic.pDynamicStates = dynamic_states.data();
  VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  rendering.depthAttachmentFormat = kAreaDepthFormat;

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
  info.stageCount = kind.fragment == VK_NULL_HANDLE ? 1 : 2;
  info.pStages = stages.data();
  info.pVertexInputState = &vertex_input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pDynamicState = &dynamic;
  info.layout = layout;
  return check_vulkan(gpu.vk.vkCreateGraphicsPipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
                      "vkCreateGraphicsPipelines");
}

Result<void> create_layout(const AreaDevice& gpu, VkPipelineLayout& layout) {
  const VkPushConstantRange range{kAreaPushStages, 0, sizeof(AreaPush)};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &range;
  return check_vulkan(gpu.vk.vkCreatePipelineLayout(gpu.device, &info, nullptr, &layout), "vkCreatePipelineLayout");
}

Result<void> create_pipelines(const AreaDevice& gpu, bool masked, Shaders& shaders, AreaPipelines& pipelines) {
  COPPICE_CHECK(create_layout(gpu, pipelines.layout));
  COPPICE_CHECK(create_module(gpu, leaf_area_vert_spirv, shaders.leaf));
  COPPICE_CHECK(create_module(gpu, leaf_area_frag_spirv, shaders.holes));
  COPPICE_CHECK(create_module(gpu, whole_view_vert_spirv, shaders.whole_view));
  const VkShaderModule fragment = masked ? shaders.holes : VK_NULL_HANDLE;
  COPPICE_CHECK(create_pipeline(gpu, pipelines.layout, {shaders.leaf, fragment, true}, pipelines.fill_depth));
  COPPICE_CHECK(create_pipeline(gpu, pipelines.layout, {shaders.leaf, fragment, false}, pipelines.count_leaf));
  return create_pipeline(gpu, pipelines.layout, {shaders.whole_view, VK_NULL_HANDLE, false}, pipelines.count_background);
}

}  // namespace

Result<void> create_area_pipelines(const AreaDevice& gpu, bool masked, AreaPipelines& pipelines) {
  Shaders shaders;
  auto created = create_pipelines(gpu, masked, shaders, pipelines);
  for (const VkShaderModule module : {shaders.leaf, shaders.holes, shaders.whole_view})
    gpu.vk.vkDestroyShaderModule(gpu.device, module, nullptr);
  return created;
}

void destroy_area_pipelines(const AreaDevice& gpu, const AreaPipelines& pipelines) {
  for (const VkPipeline pipeline : {pipelines.fill_depth, pipelines.count_leaf, pipelines.count_background})
    gpu.vk.vkDestroyPipeline(gpu.device, pipeline, nullptr);
  gpu.vk.vkDestroyPipelineLayout(gpu.device, pipelines.layout, nullptr);
}

}  // namespace coppice::bake
