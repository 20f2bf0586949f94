#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include <glm/glm.hpp>

#include "device.h"
#include "handle.h"

namespace forest {

struct Buffer {
  Handle<VkDeviceMemory> memory;  // declared first: freed after the buffer
  Handle<VkBuffer> buffer;
  std::byte* mapped = nullptr;  ///< host-visible and coherent; null for device-local
  VkDeviceSize bytes = 0;
};

struct Image {
  Handle<VkDeviceMemory> memory;
  Handle<VkImage> image;
  Handle<VkImageView> view;
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkExtent2D extent = {};
  std::uint32_t mip_count = 1;
};

inline bool same_extent(VkExtent2D a, VkExtent2D b) {
  return a.width == b.width && a.height == b.height;
}

inline glm::vec2 size_px(VkExtent2D extent) {
  return {static_cast<float>(extent.width), static_cast<float>(extent.height)};
}

struct ImageDesc {
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkExtent2D extent = {};
  VkImageUsageFlags usage = 0;
  std::uint32_t mip_count = 1;
};

Buffer create_host_buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage);
/// A device-local buffer that holds `data`; blocks until the copy is done.
Buffer create_device_buffer(const Device& device, std::span<const std::byte> data, VkBufferUsageFlags usage);
Image create_image(const Device& device, const ImageDesc& desc);
/// A sampled image of 8-bit channels with its whole mip chain: level 0 first, tightly packed. Blocks until the copy is done.
Image create_texture(const Device& device, const ImageDesc& desc, std::span<const std::byte> mips, std::uint32_t bytes_per_texel);

/// Records with `record`, submits, waits. For loading and screenshots, not for frames.
void submit_and_wait(const Device& device, const std::function<void(VkCommandBuffer)>& record);

struct ImageBarrier {
  VkImage image = VK_NULL_HANDLE;
  VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
  VkPipelineStageFlags2 from_stage = 0;
  VkAccessFlags2 from_access = 0;
  VkImageLayout from_layout = VK_IMAGE_LAYOUT_UNDEFINED;
  VkPipelineStageFlags2 to_stage = 0;
  VkAccessFlags2 to_access = 0;
  VkImageLayout to_layout = VK_IMAGE_LAYOUT_UNDEFINED;
};
void record_barrier(VkCommandBuffer commands, const ImageBarrier& barrier);
/// What was copied to buffers is next read by the host.
void record_to_host(VkCommandBuffer commands);
/// A colour image about to be drawn to from scratch: its old content is dropped, reads of it in last_stage are waited for.
ImageBarrier to_attachment(const Image& image, VkPipelineStageFlags2 last_stage);
/// A colour image that has been drawn to and is next used in `stage`.
ImageBarrier from_attachment(const Image& image, VkPipelineStageFlags2 stage, VkAccessFlags2 access, VkImageLayout layout);
/// The same of a depth image; sampled afterwards.
ImageBarrier to_depth_attachment(const Image& image, VkPipelineStageFlags2 last_stage);
ImageBarrier from_depth_attachment(const Image& image, VkPipelineStageFlags2 stage);

}  // namespace forest
