#pragma once

// Buffers and the depth image for measuring areas.

#include "area_device.h"
#include "result.h"

namespace coppice::bake {

/// A storage buffer in mapped, coherent memory.
struct AreaBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  void* mapped = nullptr;
  VkDeviceAddress address = 0;
  VkDeviceSize bytes = 0;
};

/// A square depth attachment.
struct AreaDepth {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
};

/// bytes   > 0
/// errors  those of check_vulkan; unsupported. On an error the second argument still holds what was created; destroy it.
Result<void> create_area_buffer(const AreaDevice& gpu, VkDeviceSize bytes, AreaBuffer& buffer);
Result<void> create_area_depth(const AreaDevice& gpu, std::uint32_t side_px, AreaDepth& depth);

/// The device must have finished with them.
void destroy_area_buffer(const AreaDevice& gpu, AreaBuffer& buffer);
void destroy_area_depth(const AreaDevice& gpu, AreaDepth& depth);

}  // namespace coppice::bake
