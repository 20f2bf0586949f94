#include "area_memory.h"

#include "area_pipelines.h"

namespace coppice::bake {
namespace {

struct MemoryWish {
  VkMemoryPropertyFlags properties = 0;
  VkMemoryAllocateFlags flags = 0;
};

Result<void> allocate(const AreaDevice& gpu, const VkMemoryRequirements& needs, const MemoryWish& wish, VkDeviceMemory& memory) {
  VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = wish.flags;
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags};
  info.allocationSize = needs.size;
  for (info.memoryTypeIndex = 0; info.memoryTypeIndex < gpu.memory.memoryTypeCount; ++info.memoryTypeIndex) {
    const bool allowed = (needs.memoryTypeBits >> info.memoryTypeIndex & 1u) != 0;
    const VkMemoryPropertyFlags properties = gpu.memory.memoryTypes[info.memoryTypeIndex].propertyFlags;
    if (!allowed || (properties & wish.properties) != wish.properties) continue;
    return check_vulkan(gpu.vk.vkAllocateMemory(gpu.device, &info, nullptr, &memory), "vkAllocateMemory");
  }
  return Error{Status::unsupported, "the Vulkan device has no memory of the kind that areas need"};
}

}  // namespace

Result<void> create_area_buffer(const AreaDevice& gpu, VkDeviceSize bytes, AreaBuffer& buffer) {
  buffer.bytes = bytes;
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = bytes;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  COPPICE_CHECK(check_vulkan(gpu.vk.vkCreateBuffer(gpu.device, &info, nullptr, &buffer.buffer), "vkCreateBuffer"));
  VkMemoryRequirements needs{};
  gpu.vk.vkGetBufferMemoryRequirements(gpu.device, buffer.buffer, &needs);
  COPPICE_CHECK(allocate(
      gpu, needs, {VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT},
      buffer.memory));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkBindBufferMemory(gpu.device, buffer.buffer, buffer.memory, 0), "vkBindBufferMemory"));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkMapMemory(gpu.device, buffer.memory, 0, VK_WHOLE_SIZE, 0, &buffer.mapped), "vkMapMemory"));
  VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
  address.buffer = buffer.buffer;
  buffer.address = gpu.vk.vkGetBufferDeviceAddress(gpu.device, &address);
  return {};
}

Result<void> create_area_depth(const AreaDevice& gpu, std::uint32_t side_px, AreaDepth& depth) {
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = kAreaDepthFormat;
  info.extent = {side_px, side_px, 1};
  info.mipLevels = 1;
  info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  COPPICE_CHECK(check_vulkan(gpu.vk.vkCreateImage(gpu.device, &info, nullptr, &depth.image), "vkCreateImage"));
  VkMemoryRequirements needs{};
  gpu.vk.vkGetImageMemoryRequirements(gpu.device, depth.image, &needs);
  COPPICE_CHECK(allocate(gpu, needs, {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0}, depth.memory));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkBindImageMemory(gpu.device, depth.image, depth.memory, 0), "vkBindImageMemory"));
  VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  view.image = depth.image;
  view.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view.format = kAreaDepthFormat;
  view.subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1};
  return check_vulkan(gpu.vk.vkCreateImageView(gpu.device, &view, nullptr, &depth.view), "vkCreateImageView");
}

void destroy_area_buffer(const AreaDevice& gpu, AreaBuffer& buffer) {
  gpu.vk.vkDestroyBuffer(gpu.device, buffer.buffer, nullptr);
  gpu.vk.vkFreeMemory(gpu.device, buffer.memory, nullptr);
  buffer = {};
}

void destroy_area_depth(const AreaDevice& gpu, AreaDepth& depth) {
  gpu.vk.vkDestroyImageView(gpu.device, depth.view, nullptr);
  gpu.vk.vkDestroyImage(gpu.device, depth.image, nullptr);
  gpu.vk.vkFreeMemory(gpu.device, depth.memory, nullptr);
  depth = {};
}

}  // namespace coppice::bake
