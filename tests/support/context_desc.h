#pragma once

#include "coppice/coppice.h"
#include "vulkan_device.h"

namespace coppice::test {

/// Defaults and the device; without the compute rasteriser, of which most tests ask nothing, and with
/// pictures that miss nothing.
inline coppice_context_desc context_desc(const VulkanDevice& gpu) {
  coppice_context_desc desc;
  coppice_context_desc_init(&desc);
  desc.instance = gpu.instance;
  desc.physical_device = gpu.physical_device;
  desc.device = gpu.device;
  desc.get_instance_proc_addr = vkGetInstanceProcAddr;
  desc.compute_raster = VK_FALSE;
  desc.blocking_pipelines = VK_TRUE;
  return desc;
}

}  // namespace coppice::test
