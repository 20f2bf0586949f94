#include "resources.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "failure.h"
#include "vk_struct.h"

namespace forest {
namespace {

std::uint32_t memory_type(const Device& device, std::uint32_t allowed, VkMemoryPropertyFlags properties) {
  for (std::uint32_t i = 0; i < device.memory.memoryTypeCount; ++i)
    if ((allowed >> i & 1) && (device.memory.memoryTypes[i].propertyFlags & properties) == properties) return i;
  throw Failure("the Vulkan device has no suitable memory type");
}

Handle<VkDeviceMemory> allocate(const Device& device, const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties) {
  VkMemoryAllocateInfo info = vk_struct<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  info.allocationSize = requirements.size;
  info.memoryTypeIndex = memory_type(device, requirements.memoryTypeBits, properties);
  VkDeviceMemory memory = VK_NULL_HANDLE;
  check(vkAllocateMemory(device.handle, &info, nullptr, &memory), "vkAllocateMemory");
  return {device.handle, memory, vkFreeMemory};
}

Buffer create_buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, VkMemoryPropertyFlags properties) {
  VkBufferCreateInfo info = vk_struct<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = bytes;
  info.usage = usage;
  VkBuffer handle = VK_NULL_HANDLE;
  check(vkCreateBuffer(device.handle, &info, nullptr, &handle), "vkCreateBuffer");
  Buffer buffer;
  buffer.buffer = {device.handle, handle, vkDestroyBuffer};
  buffer.bytes = bytes;
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device.handle, handle, &requirements);
  buffer.memory = allocate(device, requirements, properties);
  check(vkBindBufferMemory(device.handle, handle, buffer.memory, 0), "vkBindBufferMemory");
  return buffer;
}

constexpr ImageBarrier whole_copy_barrier(VkImage image, bool before) {
  ImageBarrier barrier;
  barrier.image = image;
  barrier.from_stage = before ? VK_PIPELINE_STAGE_2_NONE : VK_PIPELINE_STAGE_2_COPY_BIT;
  barrier.from_access = before ? VK_ACCESS_2_NONE : VK_ACCESS_2_TRANSFER_WRITE_BIT;
  barrier.from_layout = before ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  barrier.to_stage = before ? VK_PIPELINE_STAGE_2_COPY_BIT : VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
  barrier.to_access = before ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_SHADER_SAMPLED_READ_BIT;
  barrier.to_layout = before ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  return barrier;
}

}  // namespace

Buffer create_host_buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage) {
  Buffer buffer = create_buffer(device, bytes, usage, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  void* mapped = nullptr;
  check(vkMapMemory(device.handle, buffer.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
  buffer.mapped = static_cast<std::byte*>(mapped);
  return buffer;
}

Buffer create_device_buffer(const Device& device, std::span<const std::byte> data, VkBufferUsageFlags usage) {
  Buffer staging = create_host_buffer(device, data.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  std::memcpy(staging.mapped, data.data(), data.size());
  Buffer buffer = create_buffer(device, data.size(), usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  submit_and_wait(device, [&](VkCommandBuffer commands) {
    const VkBufferCopy region{0, 0, data.size()};
    vkCmdCopyBuffer(commands, staging.buffer, buffer.buffer, 1, &region);
  });
  return buffer;
}

Image create_image(const Device& device, const ImageDesc& desc) {
  VkImageCreateInfo info = vk_struct<VkImageCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO);
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = desc.format;
  info.extent = {desc.extent.width, desc.extent.height, 1};
  info.mipLevels = desc.mip_count;
  info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = desc.usage;
  VkImage handle = VK_NULL_HANDLE;
  check(vkCreateImage(device.handle, &info, nullptr, &handle), "vkCreateImage");
  Image image;
  image.image = {device.handle, handle, vkDestroyImage};
  image.format = desc.format;
  image.extent = desc.extent;
  image.mip_count = desc.mip_count;
  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(device.handle, handle, &requirements);
  image.memory = allocate(device, requirements, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  check(vkBindImageMemory(device.handle, handle, image.memory, 0), "vkBindImageMemory");

  VkImageViewCreateInfo view = vk_struct<VkImageViewCreateInfo>(VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO);
  view.image = handle;
  view.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view.format = desc.format;
  view.subresourceRange = {desc.usage & VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT,
                           0, desc.mip_count, 0, 1};
  VkImageView view_handle = VK_NULL_HANDLE;
  check(vkCreateImageView(device.handle, &view, nullptr, &view_handle), "vkCreateImageView");
  image.view = {device.handle, view_handle, vkDestroyImageView};
  return image;
}

Image create_texture(const Device& device, const ImageDesc& desc, std::span<const std::byte> mips, std::uint32_t bytes_per_texel) {
  ImageDesc sampled = desc;
  sampled.usage |= VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  Image image = create_image(device, sampled);
  Buffer staging = create_host_buffer(device, mips.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  std::memcpy(staging.mapped, mips.data(), mips.size());
  std::vector<VkBufferImageCopy> regions;
  VkDeviceSize offset = 0;
  for (std::uint32_t mip = 0; mip < desc.mip_count; ++mip) {
    VkBufferImageCopy region{};
    region.bufferOffset = offset;
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, mip, 0, 1};
    region.imageExtent = {std::max(desc.extent.width >> mip, 1u), std::max(desc.extent.height >> mip, 1u), 1};
    offset += VkDeviceSize{region.imageExtent.width} * region.imageExtent.height * bytes_per_texel;
    regions.push_back(region);
  }
  if (offset != mips.size()) throw Failure("create_texture: the mip chain has the wrong size");
  submit_and_wait(device, [&](VkCommandBuffer commands) {
    record_barrier(commands, whole_copy_barrier(image.image, true));
    vkCmdCopyBufferToImage(commands, staging.buffer, image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<std::uint32_t>(regions.size()), regions.data());
    record_barrier(commands, whole_copy_barrier(image.image, false));
  });
  return image;
}

void submit_and_wait(const Device& device, const std::function<void(VkCommandBuffer)>& record) {
  VkCommandPoolCreateInfo pool_info = vk_struct<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  pool_info.queueFamilyIndex = device.queue_family;
  VkCommandPool pool_handle = VK_NULL_HANDLE;
  check(vkCreateCommandPool(device.handle, &pool_info, nullptr, &pool_handle), "vkCreateCommandPool");
  const Handle<VkCommandPool> pool(device.handle, pool_handle, vkDestroyCommandPool);
  VkCommandBufferAllocateInfo info = vk_struct<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  info.commandPool = pool;
  info.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  check(vkAllocateCommandBuffers(device.handle, &info, &commands), "vkAllocateCommandBuffers");
  VkCommandBufferBeginInfo begin = vk_struct<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
  record(commands);
  check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
  VkCommandBufferSubmitInfo submitted = vk_struct<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
  submitted.commandBuffer = commands;
  VkSubmitInfo2 submit = vk_struct<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &submitted;
  const VkFenceCreateInfo fence_info = vk_struct<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  VkFence fence_handle = VK_NULL_HANDLE;
  check(vkCreateFence(device.handle, &fence_info, nullptr, &fence_handle), "vkCreateFence");
  const Handle<VkFence> fence(device.handle, fence_handle, vkDestroyFence);
  check(vkQueueSubmit2(device.queue, 1, &submit, fence), "vkQueueSubmit2");
  check(wait_patiently(device, "a copy",
                       [&](std::uint64_t limit_ns) { return vkWaitForFences(device.handle, 1, fence.address(), VK_TRUE, limit_ns); }),
        "vkWaitForFences");
}

void record_barrier(VkCommandBuffer commands, const ImageBarrier& barrier) {
  VkImageMemoryBarrier2 image = vk_struct<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
  image.srcStageMask = barrier.from_stage;
  image.srcAccessMask = barrier.from_access;
  image.dstStageMask = barrier.to_stage;
  image.dstAccessMask = barrier.to_access;
  image.oldLayout = barrier.from_layout;
  image.newLayout = barrier.to_layout;
  image.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  image.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  image.image = barrier.image;
  image.subresourceRange = {barrier.aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  VkDependencyInfo dependency = vk_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &image;
  vkCmdPipelineBarrier2(commands, &dependency);
}

void record_to_host(VkCommandBuffer commands) {
  VkMemoryBarrier2 barrier = vk_struct<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
  barrier.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
  barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  barrier.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
  VkDependencyInfo dependency = vk_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &dependency);
}

ImageBarrier to_attachment(const Image& image, VkPipelineStageFlags2 last_stage) {
  ImageBarrier barrier;
  barrier.image = image.image;
  barrier.from_stage = last_stage;
  barrier.to_stage = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
  barrier.to_access = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT;
  barrier.to_layout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
  return barrier;
}

ImageBarrier from_attachment(const Image& image, VkPipelineStageFlags2 stage, VkAccessFlags2 access, VkImageLayout layout) {
  ImageBarrier barrier;
  barrier.image = image.image;
  barrier.from_stage = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
  barrier.from_access = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT;
  barrier.from_layout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
  barrier.to_stage = stage;
  barrier.to_access = access;
  barrier.to_layout = layout;
  return barrier;
}

namespace {
constexpr VkPipelineStageFlags2 kDepthTests = VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
}  // namespace

ImageBarrier to_depth_attachment(const Image& image, VkPipelineStageFlags2 last_stage) {
  ImageBarrier barrier = to_attachment(image, last_stage);
  barrier.aspect = VK_IMAGE_ASPECT_DEPTH_BIT;
  barrier.to_stage = kDepthTests;
  barrier.to_access = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
  return barrier;
}

ImageBarrier from_depth_attachment(const Image& image, VkPipelineStageFlags2 stage) {
  ImageBarrier barrier = from_attachment(image, stage, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  barrier.aspect = VK_IMAGE_ASPECT_DEPTH_BIT;
  barrier.from_stage = kDepthTests;
  barrier.from_access = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  return barrier;
}

}  // namespace forest
