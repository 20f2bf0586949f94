#pragma once

// What Vulkan layers of ours share: the calls of the layer or driver below, tables of their own, and what they keep of each instance and
// device. VKAPI_ATTR and VKAPI_CALL are left out: they are empty on Linux.

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include <vulkan/vk_layer.h>

namespace layer {

using Callbacks = const VkAllocationCallbacks*;

template <class Call, class State>
Call next_call(const State& state, const char* name) {
  return reinterpret_cast<Call>(state.next(state.handle, name));
}
// A call of the layer or driver below, of an instance or device.
#define NEXT(state, call) layer::next_call<PFN_vk##call>(state, "vk" #call)

/// A row of a table of functions by the names of their calls.
#define OURS(call, function) std::pair("vk" #call, reinterpret_cast<PFN_vkVoidFunction>(static_cast<PFN_vk##call>(function)))
using Functions = std::map<std::string_view, PFN_vkVoidFunction>;
/// Null: none of that name.
inline PFN_vkVoidFunction find_function(const Functions& functions, std::string_view name) {
  const auto found = functions.find(name);
  return found == functions.end() ? nullptr : found->second;
}

template <class Handle>
std::uint64_t number_of(Handle handle) {
  return reinterpret_cast<std::uint64_t>(handle);
}

/// The loader's link to the next layer, taken off the chain; null: there is none.
template <class Link, class Info>
decltype(Link::u.pLayerInfo) take_link(const Info& info, VkStructureType type) {
  auto* link = static_cast<Link*>(const_cast<void*>(info.pNext));
  while (link != nullptr && !(link->sType == type && link->function == VK_LAYER_LINK_INFO))
    link = static_cast<Link*>(const_cast<void*>(link->pNext));
  return link != nullptr ? std::exchange(link->u.pLayerInfo, link->u.pLayerInfo->pNext) : nullptr;
}

struct Instance {
  VkInstance handle = VK_NULL_HANDLE;
  PFN_vkGetInstanceProcAddr next = nullptr;
  // Asked for at once: later the loader answers with the first layer's.
  PFN_vkDestroyInstance destroy_instance = nullptr;
  PFN_vkCreateDevice create_device = nullptr;
  PFN_vkGetPhysicalDeviceFeatures2 get_physical_device_features2 = nullptr;
  PFN_vkGetPhysicalDeviceProperties2 get_physical_device_properties2 = nullptr;
  PFN_vkGetPhysicalDeviceMemoryProperties get_physical_device_memory_properties = nullptr;
  PFN_vkEnumerateDeviceExtensionProperties enumerate_device_extension_properties = nullptr;

  VkResult create(const VkInstanceCreateInfo* info, Callbacks callbacks, VkInstance* made) {
    const auto* link = take_link<VkLayerInstanceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
    next = link->pfnNextGetInstanceProcAddr;
    if (const VkResult result = NEXT(*this, CreateInstance)(info, callbacks, made); result != VK_SUCCESS) return result;
    handle = *made;
    destroy_instance = NEXT(*this, DestroyInstance);
    create_device = NEXT(*this, CreateDevice);
    get_physical_device_features2 = NEXT(*this, GetPhysicalDeviceFeatures2);
    get_physical_device_properties2 = NEXT(*this, GetPhysicalDeviceProperties2);
    get_physical_device_memory_properties = NEXT(*this, GetPhysicalDeviceMemoryProperties);
    enumerate_device_extension_properties = NEXT(*this, EnumerateDeviceExtensionProperties);
    return VK_SUCCESS;
  }
};

struct Device {
  VkDevice handle = VK_NULL_HANDLE;
  PFN_vkGetDeviceProcAddr next = nullptr;

  VkResult create(const Instance& instance, VkPhysicalDevice physical, const VkDeviceCreateInfo* info, Callbacks callbacks,
                  VkDevice* made) {
    const auto* link = take_link<VkLayerDeviceCreateInfo>(*info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
    next = link->pfnNextGetDeviceProcAddr;
    const VkResult result = instance.create_device(physical, info, callbacks, made);
    if (result == VK_SUCCESS) handle = *made;
    return result;
  }
};

/// What a layer keeps of whatever is dispatched by the same loader's table.
template <class State>
class States {
 public:
  State& of(const void* handle) {
    const std::lock_guard lock(mutex_);
    return *states_.at(*static_cast<void* const*>(handle));
  }
  void add(const void* handle, std::unique_ptr<State> state) {
    const std::lock_guard lock(mutex_);
    states_[*static_cast<void* const*>(handle)] = std::move(state);
  }
  std::unique_ptr<State> take(const void* handle) {
    const std::lock_guard lock(mutex_);
    return std::move(states_.extract(*static_cast<void* const*>(handle)).mapped());
  }

 private:
  std::mutex mutex_;
  std::map<void*, std::unique_ptr<State>> states_;
};

inline VkResult negotiate(VkNegotiateLayerInterface* version, PFN_vkGetInstanceProcAddr of_instance, PFN_vkGetDeviceProcAddr of_device) {
  version->loaderLayerInterfaceVersion = std::min(version->loaderLayerInterfaceVersion, 2u);
  version->pfnGetInstanceProcAddr = of_instance;
  version->pfnGetDeviceProcAddr = of_device;
  version->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}

}  // namespace layer
