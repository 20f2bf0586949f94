#include "counted_memory.h"

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <unordered_map>

#include "vulkan_device.h"

namespace coppice::test {
namespace {

struct Counts {
  std::atomic<std::uint64_t> live_bytes = 0;
  std::unordered_map<VkDeviceMemory, VkDeviceSize> device_allocations;
  CountedCalls device_calls;
};

Counts& counts() {
  static Counts counts;
  return counts;
}

VKAPI_ATTR VkResult VKAPI_CALL allocate_memory(VkDevice device, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks* callbacks,
                                               VkDeviceMemory* memory) {
  const VkResult result = vkAllocateMemory(device, info, callbacks, memory);
  if (result != VK_SUCCESS) return result;
  counts().device_allocations[*memory] = info->allocationSize;
  counts().live_bytes += info->allocationSize;
  ++counts().device_calls.calls;
  ++counts().device_calls.live;
  return result;
}

VKAPI_ATTR void VKAPI_CALL free_memory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* callbacks) {
  if (memory != VK_NULL_HANDLE) {
    counts().live_bytes -= counts().device_allocations[memory];
    --counts().device_calls.live;
  }
  vkFreeMemory(device, memory, callbacks);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device_proc_addr(VkDevice device, const char* name) {
  if (std::strcmp(name, "vkAllocateMemory") == 0) return reinterpret_cast<PFN_vkVoidFunction>(allocate_memory);
  if (std::strcmp(name, "vkFreeMemory") == 0) return reinterpret_cast<PFN_vkVoidFunction>(free_memory);
  return vkGetDeviceProcAddr(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_instance_proc_addr(VkInstance instance, const char* name) {
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) return reinterpret_cast<PFN_vkVoidFunction>(get_device_proc_addr);
  return vkGetInstanceProcAddr(instance, name);
}

}  // namespace

void count_memory(ContextDesc& desc) {
  desc.get_instance_proc_addr = get_instance_proc_addr;
  desc.hooks.allocator = {sizeof(coppice_allocator), nullptr,
                          [](void*, std::size_t bytes, std::size_t align) -> void* {
                            counts().live_bytes += bytes;
                            return std::aligned_alloc(align, (bytes + align - 1) / align * align);
                          },
                          [](void*, void* pointer, std::size_t bytes) {
                            counts().live_bytes -= bytes;
                            std::free(pointer);
                          }};
}

std::uint64_t counted_bytes() {
  return counts().live_bytes;
}

CountedCalls counted_device_calls() {
  return counts().device_calls;
}

}  // namespace coppice::test
