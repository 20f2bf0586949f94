#include "counted_memory.h"

#include <atomic>
#include <cstdlib>
#include <unordered_map>

#include "replaced_functions.h"

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

}  // namespace

void count_memory(ContextDesc& desc) {
  replace_functions(desc, {replacing("vkAllocateMemory", allocate_memory), replacing("vkFreeMemory", free_memory)});
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
