#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string>

#include <volk.h>

namespace forest {

struct DeviceOptions {
  bool validation = false;                           ///< core and synchronization validation, counted in Device::messages
  std::span<const char* const> instance_extensions;  ///< what the window system asks for; empty for headless
  bool swapchain = false;
};

/// One Vulkan 1.3 device with one graphics queue, and everything coppice.h asks of a device switched on.
struct Device {
  VkInstance instance = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice handle = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queue_family = 0;
  std::string name;
  std::string driver;                   ///< its name and version
  bool software = false;                ///< a processor does the GPU's work
  bool texture_compression_bc = false;  ///< where there is one, it is enabled
  bool int64_atomics = false;           ///< shaderInt64 and shaderBufferInt64Atomics, likewise
  VkPhysicalDeviceMemoryProperties memory = {};
  std::atomic<std::uint32_t> messages = 0;  ///< validation warnings and errors so far

  /// errors  Failure: no loader, no layer (with validation), no device with Vulkan 1.3, a missing feature (named)
  explicit Device(const DeviceOptions& options);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();
};

}  // namespace forest
