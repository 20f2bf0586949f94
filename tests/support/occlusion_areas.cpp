#include "occlusion_areas.h"

#include <array>
#include <cstddef>
#include <cstring>
#include <stdexcept>

#include "masked_leaf_frag.h"
#include "masked_leaf_vert.h"

namespace coppice::test {
namespace {

constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr std::uint32_t kVerticesPerQuad = 6;
constexpr VkShaderStageFlags kPushStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

struct Vertex {
  glm::vec3 position;
  glm::vec2 uv;
};

/// Layout of the shaders' push constants.
struct Push {
  glm::mat4 clip_from_object;
  VkDeviceAddress holes = 0;
  std::uint32_t mask_width = 0;
  std::uint32_t mask_height = 0;
};
static_assert(sizeof(Push) == 80);

Buffer upload_triangles(const VulkanDevice& gpu, const MaskedQuads& quads) {
  const std::size_t quad_count = quads.corners.size() / 4;
  Buffer buffer(gpu, quad_count * kVerticesPerQuad * sizeof(Vertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  auto* out = static_cast<Vertex*>(buffer.mapped());
  for (std::size_t quad = 0; quad < quad_count; ++quad) {
    for (const std::size_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) *out++ = {quads.corners[quad * 4 + corner], quads.uvs[quad * 4 + corner]};
  }
  return buffer;
}

/// A whole number of words, at least one.
Buffer upload_mask(const VulkanDevice& gpu, const MaskedQuads& quads) {
  Buffer buffer(gpu, (quads.holes.size() / 4 + 1) * 4, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
  if (!quads.holes.empty()) std::memcpy(buffer.mapped(), quads.holes.data(), quads.holes.size());
  return buffer;
}

VkDeviceAddress device_address(const VulkanDevice& gpu, const Buffer& buffer) {
  VkBufferDeviceAddressInfo info{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  info.buffer = buffer.handle();
  return vkGetBufferDeviceAddress(gpu.device, &info);
}

struct Shaders {
  VkShaderModule vertex = VK_NULL_HANDLE;
  VkShaderModule fragment = VK_NULL_HANDLE;
};

/// depth_write on: the depth pass. Off: counts what is at exactly the depth that is there.
VkPipeline create_pipeline(const VulkanDevice& gpu, VkPipelineLayout layout, const Shaders& shaders, VkBool32 depth_write) {
  std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
  stages[0] = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
  stages[0].module = shaders.vertex;
  stages[0].pName = "main";
  stages[1] = stages[0];
  stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
  stages[1].module = shaders.fragment;
  const VkVertexInputBindingDescription binding{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX};
  const std::array attributes{VkVertexInputAttributeDescription{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
                              VkVertexInputAttributeDescription{1, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(Vertex, uv)}};
  VkPipelineVertexInputStateCreateInfo vertex_input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  vertex_input.vertexBindingDescriptionCount = 1;
  vertex_input.pVertexBindingDescriptions = &binding;
  vertex_input.vertexAttributeDescriptionCount = static_cast<std::uint32_t>(attributes.size());
  vertex_input.pVertexAttributeDescriptions = attributes.data();
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
  depth.depthWriteEnable = depth_write;
  depth.depthCompareOp = depth_write == VK_TRUE ? VK_COMPARE_OP_LESS : VK_COMPARE_OP_EQUAL;
  const std::array dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = static_cast<std::uint32_t>(dynamic_states.size());
  dynamic.pDynamicStates = dynamic_states.data();
  VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  rendering.depthAttachmentFormat = kDepthFormat;

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
  info.stageCount = static_cast<std::uint32_t>(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &vertex_input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pDynamicState = &dynamic;
  info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  check_vk(vkCreateGraphicsPipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), "vkCreateGraphicsPipelines");
  return pipeline;
}

struct Pipelines {
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline fill_depth = VK_NULL_HANDLE;
  VkPipeline count_equal = VK_NULL_HANDLE;
};

Pipelines create_pipelines(const VulkanDevice& gpu) {
  Pipelines pipelines;
  const VkPushConstantRange range{kPushStages, 0, sizeof(Push)};
  VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &range;
  check_vk(vkCreatePipelineLayout(gpu.device, &layout, nullptr, &pipelines.layout), "vkCreatePipelineLayout");
  const Shaders shaders{create_shader_module(gpu, masked_leaf_vert_spirv, sizeof masked_leaf_vert_spirv),
                        create_shader_module(gpu, masked_leaf_frag_spirv, sizeof masked_leaf_frag_spirv)};
  pipelines.fill_depth = create_pipeline(gpu, pipelines.layout, shaders, VK_TRUE);
  pipelines.count_equal = create_pipeline(gpu, pipelines.layout, shaders, VK_FALSE);
  vkDestroyShaderModule(gpu.device, shaders.vertex, nullptr);
  vkDestroyShaderModule(gpu.device, shaders.fragment, nullptr);
  return pipelines;
}

void destroy_pipelines(const VulkanDevice& gpu, const Pipelines& pipelines) {
  vkDestroyPipeline(gpu.device, pipelines.fill_depth, nullptr);
  vkDestroyPipeline(gpu.device, pipelines.count_equal, nullptr);
  vkDestroyPipelineLayout(gpu.device, pipelines.layout, nullptr);
}

void begin_depth_rendering(VkCommandBuffer cmd, const Image& depth, VkAttachmentLoadOp load) {
  VkRenderingAttachmentInfo attachment{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
  attachment.imageView = depth.view();
  attachment.imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
  attachment.loadOp = load;
  attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  attachment.clearValue.depthStencil.depth = 1.0f;
  const VkExtent2D extent{depth.desc().width_px, depth.desc().height_px};
  VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
  info.renderArea.extent = extent;
  info.layerCount = 1;
  info.pDepthAttachment = &attachment;
  vkCmdBeginRendering(cmd, &info);
  const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
  vkCmdSetViewport(cmd, 0, 1, &viewport);
  vkCmdSetScissor(cmd, 0, 1, &info.renderArea);
}

}  // namespace

std::vector<std::uint32_t> occlusion_areas(const VulkanDevice& gpu, const MaskedQuads& quads, const glm::mat4& clip_from_object,
                                           std::uint32_t side_px, const VkRect2D& counted) {
  if (!gpu.occlusion_query_precise) throw std::runtime_error("occlusion_areas: the device has no precise occlusion queries");
  const auto quad_count = static_cast<std::uint32_t>(quads.corners.size() / 4);
  const Buffer vertices = upload_triangles(gpu, quads);
  const Buffer mask = upload_mask(gpu, quads);
  const Push push{clip_from_object, device_address(gpu, mask), quads.mask_width, quads.mask_height};
  const Image depth(gpu, {side_px, side_px, kDepthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT});
  const Pipelines pipelines = create_pipelines(gpu);
  VkQueryPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  pool_info.queryType = VK_QUERY_TYPE_OCCLUSION;
  pool_info.queryCount = quad_count;
  VkQueryPool queries = VK_NULL_HANDLE;
  check_vk(vkCreateQueryPool(gpu.device, &pool_info, nullptr, &queries), "vkCreateQueryPool");

  submit(gpu, [&](VkCommandBuffer cmd) {
    vkCmdResetQueryPool(cmd, queries, 0, quad_count);
    change_layout(cmd, depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
    const VkDeviceSize start = 0;
    const VkBuffer buffer = vertices.handle();
    vkCmdBindVertexBuffers(cmd, 0, 1, &buffer, &start);
    vkCmdPushConstants(cmd, pipelines.layout, kPushStages, 0, sizeof push, &push);
    begin_depth_rendering(cmd, depth, VK_ATTACHMENT_LOAD_OP_CLEAR);
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.fill_depth);
    vkCmdDraw(cmd, quad_count * kVerticesPerQuad, 1, 0, 0);
    vkCmdEndRendering(cmd);
    full_barrier(cmd);
    begin_depth_rendering(cmd, depth, VK_ATTACHMENT_LOAD_OP_LOAD);
    vkCmdSetScissor(cmd, 0, 1, &counted);
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines.count_equal);
    for (std::uint32_t quad = 0; quad < quad_count; ++quad) {
      vkCmdBeginQuery(cmd, queries, quad, VK_QUERY_CONTROL_PRECISE_BIT);
      vkCmdDraw(cmd, kVerticesPerQuad, 1, quad * kVerticesPerQuad, 0);
      vkCmdEndQuery(cmd, queries, quad);
    }
    vkCmdEndRendering(cmd);
  });

  std::vector<std::uint32_t> areas(quad_count);
  check_vk(vkGetQueryPoolResults(gpu.device, queries, 0, quad_count, areas.size() * sizeof(std::uint32_t), areas.data(),
                                 sizeof(std::uint32_t), VK_QUERY_RESULT_WAIT_BIT),
           "vkGetQueryPoolResults");
  vkDestroyQueryPool(gpu.device, queries, nullptr);
  destroy_pipelines(gpu, pipelines);
  return areas;
}

}  // namespace coppice::test
