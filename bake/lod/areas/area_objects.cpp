#include "area_objects.h"

#include <span>

#include "leaf_area_frag.h"
#include "leaf_area_vert.h"
#include "whole_view_vert.h"

namespace coppice::bake {
namespace {

constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

struct MemoryWish {
  VkMemoryPropertyFlags properties = 0;
  VkMemoryAllocateFlags flags = 0;
};

Result<void> allocate(const AreaDevice& gpu, const VkMemoryRequirements& needs, const MemoryWish& wish, VkDeviceMemory& memory) {
  const VkMemoryAllocateFlagsInfo flags{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, .flags = wish.flags};
  VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .pNext = &flags, .allocationSize = needs.size};
  for (; info.memoryTypeIndex < gpu.memory.memoryTypeCount; ++info.memoryTypeIndex) {
    const bool allowed = (needs.memoryTypeBits >> info.memoryTypeIndex & 1u) != 0;
    const VkMemoryPropertyFlags properties = gpu.memory.memoryTypes[info.memoryTypeIndex].propertyFlags;
    if (!allowed || (properties & wish.properties) != wish.properties) continue;
    return check_vulkan(gpu.vk.vkAllocateMemory(gpu.device, &info, nullptr, &memory), "vkAllocateMemory");
  }
  return Error{Status::unsupported, "the Vulkan device has no memory of the kind that areas need"};
}

struct Shaders {
  VkShaderModule leaf = VK_NULL_HANDLE, holes = VK_NULL_HANDLE, whole_view = VK_NULL_HANDLE;
};

struct PipelineKind {
  VkShaderModule vertex = VK_NULL_HANDLE;
  VkShaderModule fragment = VK_NULL_HANDLE;  ///< may be null
  bool depth_write = false;                  ///< and the test is for nearer; else for equal
};

Result<void> create_module(const AreaDevice& gpu, std::span<const std::uint32_t> words, VkShaderModule& module) {
  const VkShaderModuleCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = words.size_bytes(), .pCode = words.data()};
  return check_vulkan(gpu.vk.vkCreateShaderModule(gpu.device, &info, nullptr, &module), "vkCreateShaderModule");
}

Result<void> create_pipeline(const AreaDevice& gpu, VkPipelineLayout layout, const PipelineKind& kind, VkPipeline& pipeline) {
  const auto stage = [](VkShaderStageFlagBits bit, VkShaderModule module) {
    return VkPipelineShaderStageCreateInfo{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = bit, .module = module, .pName = "main"};
  };
  const std::array stages{stage(VK_SHADER_STAGE_VERTEX_BIT, kind.vertex), stage(VK_SHADER_STAGE_FRAGMENT_BIT, kind.fragment)};
  const VkPipelineVertexInputStateCreateInfo vertex_input{.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const VkPipelineInputAssemblyStateCreateInfo assembly{.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo raster{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .cullMode = VK_CULL_MODE_NONE, .lineWidth = 1.0f};
  const VkPipelineMultisampleStateCreateInfo samples{.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                     .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth{.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                    .depthTestEnable = VK_TRUE,
                                                    .depthWriteEnable = kind.depth_write ? VK_TRUE : VK_FALSE,
                                                    .depthCompareOp = kind.depth_write ? VK_COMPARE_OP_LESS : VK_COMPARE_OP_EQUAL};
  const std::array dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic{.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                 .dynamicStateCount = static_cast<std::uint32_t>(dynamic_states.size()),
                                                 .pDynamicStates = dynamic_states.data()};
  const VkPipelineRenderingCreateInfo rendering{.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                .depthAttachmentFormat = kDepthFormat};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = &rendering,
                                          .stageCount = kind.fragment == VK_NULL_HANDLE ? 1u : 2u,
                                          .pStages = stages.data(),
                                          .pVertexInputState = &vertex_input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport,
                                          .pRasterizationState = &raster,
                                          .pMultisampleState = &samples,
                                          .pDepthStencilState = &depth,
                                          .pDynamicState = &dynamic,
                                          .layout = layout};
  return check_vulkan(gpu.vk.vkCreateGraphicsPipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
                      "vkCreateGraphicsPipelines");
}

Result<void> create_pipelines(const AreaDevice& gpu, bool masked, Shaders& shaders, AreaPipelines& pipelines) {
  const VkPushConstantRange range{kAreaPushStages, 0, sizeof(AreaPush)};
  const VkPipelineLayoutCreateInfo layout{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .pushConstantRangeCount = 1, .pPushConstantRanges = &range};
  COPPICE_CHECK(check_vulkan(gpu.vk.vkCreatePipelineLayout(gpu.device, &layout, nullptr, &pipelines.layout), "vkCreatePipelineLayout"));
  COPPICE_CHECK(create_module(gpu, leaf_area_vert_spirv, shaders.leaf));
  COPPICE_CHECK(create_module(gpu, leaf_area_frag_spirv, shaders.holes));
  COPPICE_CHECK(create_module(gpu, whole_view_vert_spirv, shaders.whole_view));
  const VkShaderModule fragment = masked ? shaders.holes : VK_NULL_HANDLE;
  COPPICE_CHECK(create_pipeline(gpu, pipelines.layout, {shaders.leaf, fragment, true}, pipelines.fill_depth));
  COPPICE_CHECK(create_pipeline(gpu, pipelines.layout, {shaders.leaf, fragment, false}, pipelines.count_leaf));
  return create_pipeline(gpu, pipelines.layout, {shaders.whole_view, VK_NULL_HANDLE, false}, pipelines.count_background);
}

}  // namespace

Result<void> create_area_buffer(const AreaDevice& gpu, VkDeviceSize bytes, AreaBuffer& buffer) {
  buffer.bytes = bytes;
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = bytes,
                                .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT};
  COPPICE_CHECK(check_vulkan(gpu.vk.vkCreateBuffer(gpu.device, &info, nullptr, &buffer.buffer), "vkCreateBuffer"));
  VkMemoryRequirements needs{};
  gpu.vk.vkGetBufferMemoryRequirements(gpu.device, buffer.buffer, &needs);
  COPPICE_CHECK(allocate(
      gpu, needs, {VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT},
      buffer.memory));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkBindBufferMemory(gpu.device, buffer.buffer, buffer.memory, 0), "vkBindBufferMemory"));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkMapMemory(gpu.device, buffer.memory, 0, VK_WHOLE_SIZE, 0, &buffer.mapped), "vkMapMemory"));
  const VkBufferDeviceAddressInfo address{.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer.buffer};
  buffer.address = gpu.vk.vkGetBufferDeviceAddress(gpu.device, &address);
  return {};
}

Result<void> create_area_depth(const AreaDevice& gpu, std::uint32_t side_px, AreaDepth& depth) {
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = kDepthFormat,
                               .extent = {side_px, side_px, 1},
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT};
  COPPICE_CHECK(check_vulkan(gpu.vk.vkCreateImage(gpu.device, &info, nullptr, &depth.image), "vkCreateImage"));
  VkMemoryRequirements needs{};
  gpu.vk.vkGetImageMemoryRequirements(gpu.device, depth.image, &needs);
  COPPICE_CHECK(allocate(gpu, needs, {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0}, depth.memory));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkBindImageMemory(gpu.device, depth.image, depth.memory, 0), "vkBindImageMemory"));
  const VkImageViewCreateInfo view{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = depth.image,
                                   .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                   .format = kDepthFormat,
                                   .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1}};
  return check_vulkan(gpu.vk.vkCreateImageView(gpu.device, &view, nullptr, &depth.view), "vkCreateImageView");
}

Result<void> create_area_pipelines(const AreaDevice& gpu, bool masked, AreaPipelines& pipelines) {
  Shaders shaders;
  auto created = create_pipelines(gpu, masked, shaders, pipelines);
  for (const VkShaderModule module : {shaders.leaf, shaders.holes, shaders.whole_view})
    gpu.vk.vkDestroyShaderModule(gpu.device, module, nullptr);
  return created;
}

void destroy_area_buffer(const AreaDevice& gpu, AreaBuffer& buffer) {
  gpu.vk.vkDestroyBuffer(gpu.device, buffer.buffer, nullptr);
  gpu.vk.vkFreeMemory(gpu.device, buffer.memory, nullptr);
  buffer = {};
}

void destroy_area_depth(const AreaDevice& gpu, const AreaDepth& depth) {
  gpu.vk.vkDestroyImageView(gpu.device, depth.view, nullptr);
  gpu.vk.vkDestroyImage(gpu.device, depth.image, nullptr);
  gpu.vk.vkFreeMemory(gpu.device, depth.memory, nullptr);
}

void destroy_area_pipelines(const AreaDevice& gpu, const AreaPipelines& pipelines) {
  for (const VkPipeline pipeline : {pipelines.fill_depth, pipelines.count_leaf, pipelines.count_background})
    gpu.vk.vkDestroyPipeline(gpu.device, pipeline, nullptr);
  gpu.vk.vkDestroyPipelineLayout(gpu.device, pipelines.layout, nullptr);
}

}  // namespace coppice::bake
