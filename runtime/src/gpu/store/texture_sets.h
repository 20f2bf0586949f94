#pragma once

// The descriptor sets of a texture: set 1 of a draw is its base colour, set 2 its normal map.

#include "descriptor_sets.h"

namespace coppice::gpu {

class TextureSets {
 public:
  /// device: outlives this object
  explicit TextureSets(Device& device) : device_(device) {}
  ~TextureSets();
  TextureSets(const TextureSets&) = delete;
  TextureSets& operator=(const TextureSets&) = delete;
  /// errors of both: out_of_memory, device_lost
  Result<void> create();
  [[nodiscard]] Result<DescriptorSet> create_set(VkImageView view) const;

  [[nodiscard]] VkDescriptorSetLayout layout() const { return layout_.layout; }

 private:
  Device& device_;
  SetLayout layout_;
  VkSampler sampler_ = VK_NULL_HANDLE;
};

}  // namespace coppice::gpu
