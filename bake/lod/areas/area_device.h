#pragma once

// The Vulkan device that measures areas.

#include <cstdint>
#include <memory>
#include <string>

#include "result.h"
#include "vulkan_functions.h"

namespace coppice::bake {

struct AreaDevice {
  AreaDevice() = default;
  AreaDevice(const AreaDevice&) = delete;
  AreaDevice& operator=(const AreaDevice&) = delete;
  ~AreaDevice();  ///< destroys what open_area_device created

  VulkanFunctions vk;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  VkPhysicalDeviceMemoryProperties memory{};
  std::string name;  ///< device and driver with its version: areas may depend on them
  bool owned = false;
};

/// Opens the loader's first device that has Vulkan 1.3, a graphics queue and precise occlusion queries.
/// errors  unsupported: no loader, no driver, no device, or none that has all of these; the error says what the last one lacks
Result<std::unique_ptr<AreaDevice>> open_area_device();

/// Somebody else's device, which outlives the result. Its features dynamicRendering, synchronization2, bufferDeviceAddress and
/// occlusionQueryPrecise are enabled. Nobody else uses the queue meanwhile.
struct BorrowedDevice {
  PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
};

/// Wraps a borrowed device. errors  unsupported: a function is missing
Result<std::unique_ptr<AreaDevice>> borrow_area_device(const BorrowedDevice& borrowed);

}  // namespace coppice::bake
