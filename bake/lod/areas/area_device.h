#pragma once

// The Vulkan device that measures areas. Vulkan is loaded on demand, so that the tool starts without it. Functions of the instance are
// volk's globals; a device has a table of its own, because tests have two.

#include <cstdint>
#include <memory>
#include <string>

#include <volk.h>

#include "result.h"

namespace coppice::bake {

struct DeviceHandles {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
};

struct AreaDevice : DeviceHandles {
  AreaDevice() = default;
  AreaDevice(const AreaDevice&) = delete;
  AreaDevice& operator=(const AreaDevice&) = delete;
  ~AreaDevice();  ///< destroys what open_area_device created

  VolkDeviceTable vk{};
  VkPhysicalDeviceMemoryProperties memory{};
  std::string name;  ///< device and driver with its version: areas may depend on them
  bool owned = false;
};

/// Opens the loader's first device that has Vulkan 1.3, a graphics queue and precise occlusion queries.
/// The program has no other instance.
/// errors  unsupported: no loader, no driver, no device, or none that has all of these; the error says what the last one lacks
Result<std::unique_ptr<AreaDevice>> open_area_device();

/// Wraps somebody else's device, which outlives the result. Its features dynamicRendering, synchronization2, bufferDeviceAddress and
/// occlusionQueryPrecise are enabled, and its owner has loaded volk's functions of the instance. Nobody else uses the queue meanwhile.
std::unique_ptr<AreaDevice> borrow_area_device(const DeviceHandles& borrowed);

/// call    the function's name
/// errors  device_lost, out_of_memory, internal
Result<void> check_vulkan(VkResult result, const char* call);

}  // namespace coppice::bake
