#pragma once

#include <coppice/vulkan.h>

#include "device.h"

namespace forest {

/// What a context of the library is told of the device; the rest is the default.
inline coppice_vulkan_desc desc_of(const Device& device) {
  coppice_vulkan_desc desc;
  coppice_vulkan_desc_init(&desc);
  desc.instance = device.instance;
  desc.physical_device = device.physical;
  desc.device = device.handle;
  desc.get_instance_proc_addr = vkGetInstanceProcAddr;
  desc.texture_compression_bc = device.texture_compression_bc ? VK_TRUE : VK_FALSE;
  desc.draw_indirect_count = device.draw_indirect_count ? VK_TRUE : VK_FALSE;
  desc.shader_int64_atomics = device.int64_atomics ? VK_TRUE : VK_FALSE;
  return desc;
}

}  // namespace forest
