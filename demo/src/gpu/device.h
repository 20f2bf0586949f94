#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include <volk.h>

namespace forest {

struct DeviceOptions {
  bool validation = false;                           ///< core and synchronization validation, counted in Device::messages
  std::span<const char* const> instance_extensions;  ///< what the window system asks for; empty for headless
  bool swapchain = false;
  float patience_s = 0;                          ///< 0: kPatience_s, or kSoftwarePatience_s where a processor does the GPU's work
  std::function<void(VkPhysicalDevice)> chosen;  ///< called before features are asked for; empty: nothing
};

/// A frame of a GPU takes milliseconds; one of a processor may take minutes.
inline constexpr float kPatience_s = 20, kSoftwarePatience_s = 600;

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
  bool draw_indirect_count = false;     ///< likewise
  bool int64_atomics = false;           ///< shaderInt64 and shaderBufferInt64Atomics, likewise
  VkPhysicalDeviceMemoryProperties memory = {};
  float patience_s = kPatience_s;           ///< see wait_patiently
  std::function<std::string()> say_state;   ///< what else is to be said where the GPU hangs; empty: nothing
  std::atomic<std::uint32_t> messages = 0;  ///< validation warnings and errors so far

  /// errors  Failure: no loader, no layer (with validation), no device with Vulkan 1.3, a missing feature (named)
  explicit Device(const DeviceOptions& options);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();
};

/// The result of `wait`, called with the nanoseconds that it may take. Where they pass and the GPU has not done it, says on the standard
/// error output what was waited for and ends the program with exit code 1, without its destructors: a device that hangs cannot be
/// destroyed. what  "frame 12"
VkResult wait_patiently(const Device& device, const std::string& what, const std::function<VkResult(std::uint64_t)>& wait);

}  // namespace forest
