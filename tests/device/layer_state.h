#pragma once

// What the layer keeps of each instance and device.

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

#include "device_rows.h"
#include "layer_calls.h"

namespace limits_layer {

using coppice::test::DeviceRow;
using layer::Callbacks;
using layer::Functions;
using layer::number_of;

struct Instance : layer::Instance {
  const DeviceRow* row = nullptr;
  std::optional<int> fill;
  bool late = false, reversed = false;
};

/// A buffer or image in an allocation.
struct Bound {
  std::uint64_t object;
  VkDeviceSize offset, bytes;
  bool optimal;
};

struct Allocation {
  VkDeviceSize bytes = 0;
  std::uint32_t type = 0;
  std::uint8_t* real = nullptr;      ///< the driver's
  std::vector<std::uint8_t> shadow;  ///< where the type is not coherent
  std::vector<Bound> bound;
};

/// What keeps submissions back: late_submits.cpp.
struct Gate {
  VkSemaphore semaphore = VK_NULL_HANDLE;  ///< a timeline that each submission waits for
  std::uint64_t submitted = 0, opened = 0;
  std::map<VkFence, std::uint64_t> fences;                                ///< which submission each belongs to
  std::map<VkSemaphore, std::map<std::uint64_t, std::uint64_t>> signals;  ///< which submission signals each value
};

struct Device : layer::Device {
  const Instance* instance = nullptr;
  VkPhysicalDeviceLimits limits{};
  VkPhysicalDeviceMemoryProperties memory{};
  VkDeviceSize max_allocation_bytes = 0;
  std::mutex mutex;  ///< guards what follows
  std::map<VkDeviceMemory, Allocation> allocations;
  std::map<VkBuffer, VkDeviceSize> buffer_bytes;
  std::map<VkImage, bool> optimal_images;
  VkDeviceSize heap_bytes[VK_MAX_MEMORY_HEAPS] = {};  ///< allocated
  Gate gate;
};

inline layer::States<Instance> instances;
inline layer::States<Device> devices;

inline Instance& instance_of(const void* handle) {
  return instances.of(handle);
}
inline Device& device_of(const void* handle) {
  return devices.of(handle);
}

/// Prints "limits_layer refuses" and what.
[[gnu::format(printf, 2, 3)]] void refuse(const DeviceRow& row, const char* format, ...);

/// A call that late_submits.cpp takes; null: none of that name.
PFN_vkVoidFunction late_function(std::string_view name);
/// A call that reversed_commands.cpp takes; null: none of that name.
PFN_vkVoidFunction reversed_function(std::string_view name);
void hold_dispatch(VkCommandBuffer cmd, std::uint32_t x, std::uint32_t y, std::uint32_t z);
/// After the device was made, before it goes. Without COPPICE_TEST_LATE nothing.
VkResult create_gate(Device& device);
void destroy_gate(Device& device);

}  // namespace limits_layer
