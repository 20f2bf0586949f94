#pragma once

// What the layer keeps of each instance and device.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <vulkan/vk_layer.h>

#include "device_rows.h"

namespace limits_layer {

using coppice::test::DeviceRow;
// VKAPI_ATTR and VKAPI_CALL are left out: they are empty on Linux.
using Callbacks = const VkAllocationCallbacks*;

template <class Call, class State>
Call next_call(const State& state, const char* name) {
  return reinterpret_cast<Call>(state.next(state.handle, name));
}
// A call of the layer or driver below, of an instance or device.
#define NEXT(state, call) next_call<PFN_vk##call>(state, "vk" #call)

struct Instance {
  VkInstance handle = VK_NULL_HANDLE;
  const DeviceRow* row = nullptr;
  std::optional<int> fill;
  bool late = false, reversed = false;
  PFN_vkGetInstanceProcAddr next = nullptr;
  // Asked for at once: later the loader answers with the first layer's.
  PFN_vkDestroyInstance destroy_instance = nullptr;
  PFN_vkCreateDevice create_device = nullptr;
  PFN_vkGetPhysicalDeviceFeatures2 get_physical_device_features2 = nullptr;
  PFN_vkGetPhysicalDeviceProperties2 get_physical_device_properties2 = nullptr;
  PFN_vkGetPhysicalDeviceMemoryProperties get_physical_device_memory_properties = nullptr;
  PFN_vkEnumerateDeviceExtensionProperties enumerate_device_extension_properties = nullptr;
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

struct Device {
  VkDevice handle = VK_NULL_HANDLE;
  const Instance* instance = nullptr;
  VkPhysicalDeviceLimits limits{};
  VkPhysicalDeviceMemoryProperties memory{};
  VkDeviceSize max_allocation_bytes = 0;
  PFN_vkGetDeviceProcAddr next = nullptr;
  std::mutex mutex;  ///< guards what follows
  std::map<VkDeviceMemory, Allocation> allocations;
  std::map<VkBuffer, VkDeviceSize> buffer_bytes;
  std::map<VkImage, bool> optimal_images;
  VkDeviceSize heap_bytes[VK_MAX_MEMORY_HEAPS] = {};  ///< allocated
  Gate gate;
};

/// Whatever was dispatched by the same loader's table.
inline std::mutex states_mutex;
inline std::map<void*, std::unique_ptr<Instance>> instances;
inline std::map<void*, std::unique_ptr<Device>> devices;

template <class State>
State& state_of(std::map<void*, std::unique_ptr<State>>& states, const void* handle) {
  const std::lock_guard lock(states_mutex);
  return *states.at(*static_cast<void* const*>(handle));
}
inline Instance& instance_of(const void* handle) {
  return state_of(instances, handle);
}
inline Device& device_of(const void* handle) {
  return state_of(devices, handle);
}

/// Prints "limits_layer refuses" and what.
[[gnu::format(printf, 2, 3)]] void refuse(const DeviceRow& row, const char* format, ...);

/// A row of a table of functions by the names of their calls.
#define OURS(call, function) std::pair("vk" #call, reinterpret_cast<PFN_vkVoidFunction>(static_cast<PFN_vk##call>(function)))
using Functions = std::map<std::string_view, PFN_vkVoidFunction>;
/// Null: none of that name.
inline PFN_vkVoidFunction find_function(const Functions& functions, std::string_view name) {
  const auto found = functions.find(name);
  return found == functions.end() ? nullptr : found->second;
}

/// A call that late_submits.cpp takes; null: none of that name.
PFN_vkVoidFunction late_function(std::string_view name);
/// A call that reversed_commands.cpp takes; null: none of that name.
PFN_vkVoidFunction reversed_function(std::string_view name);
void hold_dispatch(VkCommandBuffer cmd, std::uint32_t x, std::uint32_t y, std::uint32_t z);
/// After the device was made, before it goes. Without COPPICE_TEST_LATE nothing.
VkResult create_gate(Device& device);
void destroy_gate(Device& device);

}  // namespace limits_layer
