#include "texture_sets.h"

namespace coppice::gpu {
namespace {

/// On a processor, blending of mip levels would double the cost of a fragment's texels.
VkSamplerMipmapMode mipmap_mode(const Device& device) {
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  device.vk.vkGetPhysicalDeviceProperties2(device.physical_device, &properties);
  const bool software = properties.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  return software ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
}

}  // namespace

TextureSets::~TextureSets() {
  device_.vk.vkDestroySampler(device_.device, sampler_, nullptr);
  destroy_set_layout(device_, layout_);
}

Result<void> TextureSets::create() {
  const Binding binding{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT};
  COPPICE_CHECK(move_into(layout_, create_set_layout(device_, "coppice texture", std::span(&binding, 1))));
  const VkSamplerCreateInfo info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                 .magFilter = VK_FILTER_LINEAR,
                                 .minFilter = VK_FILTER_LINEAR,
                                 .mipmapMode = mipmap_mode(device_),
                                 .maxLod = VK_LOD_CLAMP_NONE};
  return check_created(device_, device_.vk.vkCreateSampler(device_.device, &info, nullptr, &sampler_), "vkCreateSampler", sampler_);
}

Result<DescriptorSet> TextureSets::create_set(VkImageView view) const {
  const Bound bound{.sampler = sampler_, .views = &view};
  return gpu::create_set(device_, layout_, std::span(&bound, 1));
}

}  // namespace coppice::gpu
