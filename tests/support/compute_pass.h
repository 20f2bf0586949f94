#pragma once

// A compute shader of a test, with buffers and images at the bindings of set 0.

#include <cstdint>
#include <span>
#include <vector>

#include "vulkan_device.h"

namespace coppice::test {

/// The GPU must be done with it when it goes.
class ComputePass {
 public:
  /// bindings: STORAGE_BUFFER or COMBINED_IMAGE_SAMPLER each, by their numbers
  ComputePass(const VulkanDevice& gpu, std::span<const std::uint32_t> spirv, const std::vector<VkDescriptorType>& bindings)
      : device_(gpu.device) {
    std::vector<VkDescriptorSetLayoutBinding> layouts;
    std::vector<VkDescriptorPoolSize> sizes;
    for (const VkDescriptorType type : bindings) {
      layouts.push_back({static_cast<std::uint32_t>(layouts.size()), type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
      sizes.push_back({type, 1});
    }
    const auto count = static_cast<std::uint32_t>(bindings.size());
    const VkDescriptorSetLayoutCreateInfo set_info{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = count, .pBindings = layouts.data()};
    check_vk(vkCreateDescriptorSetLayout(device_, &set_info, nullptr, &set_layout_), "vkCreateDescriptorSetLayout");
    const VkPipelineLayoutCreateInfo layout_info{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &set_layout_};
    check_vk(vkCreatePipelineLayout(device_, &layout_info, nullptr, &layout_), "vkCreatePipelineLayout");
    const VkShaderModuleCreateInfo module_info{
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = spirv.size_bytes(), .pCode = spirv.data()};
    VkShaderModule module = VK_NULL_HANDLE;
    check_vk(vkCreateShaderModule(device_, &module_info, nullptr, &module), "vkCreateShaderModule");
    const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                           .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                     .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                     .module = module,
                                                     .pName = "main"},
                                           .layout = layout_};
    check_vk(vkCreateComputePipelines(device_, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_), "vkCreateComputePipelines");
    vkDestroyShaderModule(device_, module, nullptr);
    const VkSamplerCreateInfo sampler{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    check_vk(vkCreateSampler(device_, &sampler, nullptr, &sampler_), "vkCreateSampler");
    const VkDescriptorPoolCreateInfo pool{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = count, .pPoolSizes = sizes.data()};
    check_vk(vkCreateDescriptorPool(device_, &pool, nullptr, &pool_), "vkCreateDescriptorPool");
    const VkDescriptorSetAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                               .descriptorPool = pool_,
                                               .descriptorSetCount = 1,
                                               .pSetLayouts = &set_layout_};
    check_vk(vkAllocateDescriptorSets(device_, &allocate, &set_), "vkAllocateDescriptorSets");
  }
  ~ComputePass() {
    vkDestroyDescriptorPool(device_, pool_, nullptr);
    vkDestroySampler(device_, sampler_, nullptr);
    vkDestroyPipeline(device_, pipeline_, nullptr);
    vkDestroyPipelineLayout(device_, layout_, nullptr);
    vkDestroyDescriptorSetLayout(device_, set_layout_, nullptr);
  }
  ComputePass(const ComputePass&) = delete;
  ComputePass& operator=(const ComputePass&) = delete;

  void bind(std::uint32_t binding, const Buffer& buffer) {
    const VkDescriptorBufferInfo info{buffer.handle(), 0, VK_WHOLE_SIZE};
    write({.dstBinding = binding, .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .pBufferInfo = &info});
  }
  /// It has to be in SHADER_READ_ONLY_OPTIMAL when the shader runs.
  void bind(std::uint32_t binding, const Image& image) {
    const VkDescriptorImageInfo info{sampler_, image.view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    write({.dstBinding = binding, .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, .pImageInfo = &info});
  }

  void record(VkCommandBuffer cmd, std::uint32_t groups_x, std::uint32_t groups_y) {
    vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vkCmdBindDescriptorSets(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
    vkCmdDispatch(cmd, groups_x, groups_y, 1);
  }

 private:
  void write(VkWriteDescriptorSet write) {
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = set_;
    write.descriptorCount = 1;
    vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
  }

  VkDevice device_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkSampler sampler_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace coppice::test
