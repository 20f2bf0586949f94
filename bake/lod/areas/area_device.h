#pragma once

// The Vulkan device that measures areas. Its functions are loaded on demand, so that the tool starts without Vulkan.

#include <cstdint>
#include <memory>
#include <string>

#include <volk.h>

#include "result.h"

namespace coppice::bake {

#define COPPICE_AREA_INSTANCE_FUNCTIONS(X) \
  X(vkCreateDevice)                        \
  X(vkDestroyInstance)                     \
  X(vkEnumeratePhysicalDevices)            \
  X(vkGetDeviceProcAddr)                   \
  X(vkGetPhysicalDeviceFeatures2)          \
  X(vkGetPhysicalDeviceFormatProperties)   \
  X(vkGetPhysicalDeviceMemoryProperties)   \
  X(vkGetPhysicalDeviceProperties2)        \
  X(vkGetPhysicalDeviceQueueFamilyProperties)

/// The functions of one instance and one device. They are no globals like volk's, which serve one device per program: tests have two.
struct VulkanFunctions : VolkDeviceTable {
#define COPPICE_DECLARE(name) PFN_##name name = nullptr;
  COPPICE_AREA_INSTANCE_FUNCTIONS(COPPICE_DECLARE)
#undef COPPICE_DECLARE
};

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

  VulkanFunctions vk{};
  VkPhysicalDeviceMemoryProperties memory{};
  std::string name;  ///< device and driver with its version: areas may depend on them
  bool owned = false;
};

/// Opens the loader's first device that has Vulkan 1.3, a graphics queue and precise occlusion queries.
/// errors  unsupported: no loader, no driver, no device, or none that has all of these; the error says what the last one lacks
Result<std::unique_ptr<AreaDevice>> open_area_device();

/// Wraps somebody else's device, which outlives the result. Its features dynamicRendering, synchronization2, bufferDeviceAddress and
/// occlusionQueryPrecise are enabled, and its owner has initialised volk. Nobody else uses the queue meanwhile.
/// errors  unsupported: a function is missing
Result<std::unique_ptr<AreaDevice>> borrow_area_device(const DeviceHandles& borrowed);

/// call    the function's name
/// errors  device_lost, out_of_memory, internal
Result<void> check_vulkan(VkResult result, const char* call);

}  // namespace coppice::bake
