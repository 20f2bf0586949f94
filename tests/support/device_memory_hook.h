#pragma once

// An engine's device memory: counts, can fail, and gives runs in the middle of its own memory.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

#include "vulkan_device.h"

namespace coppice::test {

struct DeviceMemoryHook {
  const VulkanDevice* gpu = nullptr;  ///< null: the memory is numbers
  std::size_t calls = 0, live_count = 0;
  std::uint64_t live_bytes = 0;
  std::size_t fail_at = SIZE_MAX;  ///< index of the call that finds no memory
  std::uint32_t memory_type = 0;   ///< without a device
  std::map<void*, std::uint64_t> sizes;
  std::string misuse;  ///< what no engine could serve

  coppice_device_memory hook() { return {sizeof(coppice_device_memory), this, allocate, free}; }

 private:
  static VkResult allocate(void* user, const VkMemoryRequirements* requirements, VkMemoryPropertyFlags properties,
                           coppice_memory_block* block) {
    auto& self = *static_cast<DeviceMemoryHook*>(user);
    if (self.calls++ == self.fail_at) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    if (requirements->alignment == 0 || (requirements->alignment & (requirements->alignment - 1)) != 0) self.misuse = "alignment";
    if (requirements->size == 0) self.misuse = "size";
    block->offset = 3 * requirements->alignment;
    block->memory_type = self.gpu != nullptr ? self.gpu->memory_type(requirements->memoryTypeBits, properties) : self.memory_type;
    if (const VkResult result = self.allocate_memory(*requirements, properties, *block); result != VK_SUCCESS) return result;
    block->handle = reinterpret_cast<void*>(self.calls);
    self.sizes[block->handle] = requirements->size;
    ++self.live_count;
    self.live_bytes += requirements->size;
    return VK_SUCCESS;
  }
  static void free(void* user, const coppice_memory_block* block) {
    auto& self = *static_cast<DeviceMemoryHook*>(user);
    if (!self.sizes.contains(block->handle)) self.misuse = "freed twice";
    --self.live_count;
    self.live_bytes -= self.sizes[block->handle];
    self.sizes.erase(block->handle);
    if (self.gpu != nullptr) vkFreeMemory(self.gpu->device, block->memory, nullptr);
  }

  VkResult allocate_memory(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties, coppice_memory_block& block) const {
    if (gpu == nullptr) {
      block.memory = reinterpret_cast<VkDeviceMemory>(calls);
      block.mapped = &block;
      return VK_SUCCESS;
    }
    const VkMemoryAllocateFlagsInfo flags{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                          .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                    .pNext = &flags,
                                    .allocationSize = requirements.size + block.offset,
                                    .memoryTypeIndex = block.memory_type};
    const VkResult result = vkAllocateMemory(gpu->device, &info, nullptr, &block.memory);
    if (result != VK_SUCCESS || !(properties & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)) return result;
    return vkMapMemory(gpu->device, block.memory, block.offset, VK_WHOLE_SIZE, 0, &block.mapped);
  }
};

}  // namespace coppice::test
