#include "descriptor_sets.h"

#include <algorithm>

#include "check.h"
#include "debug_label.h"

namespace coppice::gpu {

Result<SetLayout> create_set_layout(Device& device, const char* name, std::span<const Binding> bindings) {
  COPPICE_ASSERT(bindings.size() <= kMaxBindings);
  SetLayout made{.name = name, .binding_count = static_cast<std::uint32_t>(bindings.size())};
  std::ranges::copy(bindings, made.bindings.begin());
  std::array<VkDescriptorSetLayoutBinding, kMaxBindings> infos{};
  for (std::uint32_t i = 0; i < made.binding_count; ++i)
    infos[i] = {.binding = i, .descriptorType = bindings[i].type, .descriptorCount = bindings[i].count, .stageFlags = bindings[i].stages};
  const VkDescriptorSetLayoutCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = made.binding_count, .pBindings = infos.data()};
  COPPICE_CHECK(
      check(device, device.vk.vkCreateDescriptorSetLayout(device.device, &info, nullptr, &made.layout), "vkCreateDescriptorSetLayout"));
  name_object(device, VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, made.layout, name);
  return made;
}

void destroy_set_layout(Device& device, SetLayout& layout) {
  device.vk.vkDestroyDescriptorSetLayout(device.device, layout.layout, nullptr);
  layout = {};
}

Result<VkPipelineLayout> create_pipeline_layout(Device& device, std::span<const VkDescriptorSetLayout> sets,
                                                const VkPushConstantRange& push) {
  const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                        .setLayoutCount = static_cast<std::uint32_t>(sets.size()),
                                        .pSetLayouts = sets.data(),
                                        .pushConstantRangeCount = 1,
                                        .pPushConstantRanges = &push};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  COPPICE_CHECK(check(device, device.vk.vkCreatePipelineLayout(device.device, &info, nullptr, &layout), "vkCreatePipelineLayout"));
  return layout;
}

namespace {

Result<DescriptorSet> allocate_set(Device& device, const SetLayout& layout) {
  std::array<VkDescriptorPoolSize, kMaxBindings> sizes{};
  for (std::uint32_t i = 0; i < layout.binding_count; ++i) sizes[i] = {layout.bindings[i].type, layout.bindings[i].count};
  const VkDescriptorPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = layout.binding_count,
                                             .pPoolSizes = sizes.data()};
  DescriptorSet made;
  COPPICE_CHECK(check(device, device.vk.vkCreateDescriptorPool(device.device, &pool_info, nullptr, &made.pool), "vkCreateDescriptorPool"));
  const VkDescriptorSetAllocateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = made.pool,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &layout.layout};
  if (auto set = check(device, device.vk.vkAllocateDescriptorSets(device.device, &set_info, &made.set), "vkAllocateDescriptorSets"); !set) {
    destroy_set(device, made);
    return set.error();
  }
  name_object(device, VK_OBJECT_TYPE_DESCRIPTOR_SET, made.set, layout.name);
  return made;
}

}  // namespace

void write_set(Device& device, const SetLayout& layout, const DescriptorSet& set, std::span<const Bound> bound) {
  COPPICE_ASSERT(bound.size() == layout.binding_count);
  std::array<VkDescriptorBufferInfo, kMaxBindings> buffers{};
  std::array<std::array<VkDescriptorImageInfo, kMaxBindingImages>, kMaxBindings> images{};
  std::array<VkWriteDescriptorSet, kMaxBindings> writes{};
  for (std::uint32_t i = 0; i < layout.binding_count; ++i) {
    const auto& [buffer, sampler, views] = bound[i];
    writes[i] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                 .dstSet = set.set,
                 .dstBinding = i,
                 .descriptorCount = layout.bindings[i].count,
                 .descriptorType = layout.bindings[i].type,
                 .pImageInfo = images[i].data(),
                 .pBufferInfo = &buffers[i],
                 .pTexelBufferView = buffer != nullptr ? &buffer->texels : nullptr};
    if (buffer != nullptr) buffers[i] = {.buffer = buffer->buffer, .range = VK_WHOLE_SIZE};
    for (std::uint32_t k = 0; buffer == nullptr && k < layout.bindings[i].count; ++k)
      images[i][k] = {sampler, views[k], VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  }
  device.vk.vkUpdateDescriptorSets(device.device, layout.binding_count, writes.data(), 0, nullptr);
}

Result<DescriptorSet> create_set(Device& device, const SetLayout& layout, std::span<const Bound> bound) {
  COPPICE_TRY(made, allocate_set(device, layout));
  write_set(device, layout, made, bound);
  return made;
}

void destroy_set(Device& device, DescriptorSet& set) {
  device.vk.vkDestroyDescriptorPool(device.device, set.pool, nullptr);
  set = {};
}

}  // namespace coppice::gpu
