#pragma once

#include <cstdint>
#include <span>

#include "device.h"
#include "handle.h"

namespace forest {

struct PipelineDesc {
  std::span<const std::uint32_t> vertex_spirv;
  std::span<const std::uint32_t> fragment_spirv;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkFormat color_format = VK_FORMAT_UNDEFINED;
  VkFormat second_color_format = VK_FORMAT_UNDEFINED;  ///< undefined: one attachment
  VkFormat depth_format = VK_FORMAT_UNDEFINED;         ///< undefined: no depth test
  bool depth_write = true;                             ///< the test is reversed depth, GREATER_OR_EQUAL
  bool alpha_blend = false;
  std::uint32_t fragment_constant = 0;  ///< constant 0 of the fragment shader, where it has one
  std::span<const VkVertexInputBindingDescription> bindings;
  std::span<const VkVertexInputAttributeDescription> attributes;
};

/// A triangle-list pipeline for dynamic rendering, no culling, dynamic viewport and scissor.
Handle<VkPipeline> create_pipeline(const Device& device, const PipelineDesc& desc);
/// push_bytes: of push constants for push_stages; 0 for none
Handle<VkPipelineLayout> create_pipeline_layout(const Device& device, VkDescriptorSetLayout set, std::uint32_t push_bytes,
                                                VkShaderStageFlags push_stages = VK_SHADER_STAGE_VERTEX_BIT);
/// Bindings 0..types.size()-1, one descriptor each, for vertex and fragment stages.
Handle<VkDescriptorSetLayout> create_set_layout(const Device& device, std::span<const VkDescriptorType> types);
/// Repeating or clamped.
Handle<VkSampler> create_sampler(const Device& device, VkSamplerAddressMode address_mode, VkFilter filter = VK_FILTER_LINEAR);

/// Viewport and scissor over a whole picture.
void record_viewport(VkCommandBuffer commands, VkExtent2D extent, VkOffset2D first = {0, 0});

}  // namespace forest
