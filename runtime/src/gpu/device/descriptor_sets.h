#pragma once

// Descriptor sets, each with a pool of its own, written when they are made.

#include <array>
#include <cstdint>
#include <span>

#include "device.h"
#include "result.h"

namespace coppice::gpu {

/// The binding of shadow maps has the most images.
inline constexpr std::uint32_t kMaxBindings = 14, kMaxBindingImages = 4;

struct Binding {
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  VkShaderStageFlags stages = 0;
  std::uint32_t count = 1;
};

struct SetLayout {
  const char* name = "";  ///< the name of its sets; static storage
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  std::array<Binding, kMaxBindings> bindings{};
  std::uint32_t binding_count = 0;
};

struct DescriptorSet {
  VkDescriptorPool pool = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
};

/// The resource of a binding: a whole buffer, as texels if it has a texel view; or `count` images in SHADER_READ_ONLY_OPTIMAL.
struct Bound {
  const Buffer* buffer = nullptr;
  VkSampler sampler = VK_NULL_HANDLE;
  const VkImageView* views = nullptr;
};

/// name: of its sets, static storage; bindings: in order, from 0 on. errors  out_of_memory, device_lost
Result<SetLayout> create_set_layout(Device& device, const char* name, std::span<const Binding> bindings);
void destroy_set_layout(Device& device, SetLayout& layout);
/// sets: from set 0 on. errors  out_of_memory, device_lost
Result<VkPipelineLayout> create_pipeline_layout(Device& device, std::span<const VkDescriptorSetLayout> sets,
                                                const VkPushConstantRange& push);
/// bound: one for each binding. errors  out_of_memory, device_lost
Result<DescriptorSet> create_set(Device& device, const SetLayout& layout, std::span<const Bound> bound);
/// set: from create_set; the GPU must be done with it
void write_set(Device& device, const SetLayout& layout, const DescriptorSet& set, std::span<const Bound> bound);
void destroy_set(Device& device, DescriptorSet& set);

}  // namespace coppice::gpu
