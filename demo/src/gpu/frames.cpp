#include "frames.h"

#include <string>

#include "failure.h"
#include "vk_struct.h"

namespace forest {
namespace {

Handle<VkSemaphore> create_semaphore(const Device& device, VkSemaphoreType type) {
  VkSemaphoreTypeCreateInfo type_info = vk_struct<VkSemaphoreTypeCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
  type_info.semaphoreType = type;
  VkSemaphoreCreateInfo info = vk_struct<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
  info.pNext = &type_info;
  VkSemaphore semaphore = VK_NULL_HANDLE;
  check(vkCreateSemaphore(device.handle, &info, nullptr, &semaphore), "vkCreateSemaphore");
  return {device.handle, semaphore, vkDestroySemaphore};
}

/// One frame after the other: each has its time.
VkResult wait_for(const Device& device, const FrameRing& ring, std::uint64_t number) {
  std::uint64_t frame = 0;
  VkResult result = vkGetSemaphoreCounterValue(device.handle, ring.timeline, &frame);
  while (result == VK_SUCCESS && frame < number) {
    ++frame;
    VkSemaphoreWaitInfo wait = vk_struct<VkSemaphoreWaitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO);
    wait.semaphoreCount = 1;
    wait.pSemaphores = ring.timeline.address();
    wait.pValues = &frame;
    result = wait_patiently(device, "frame " + std::to_string(frame),
                            [&](std::uint64_t limit_ns) { return vkWaitSemaphores(device.handle, &wait, limit_ns); });
  }
  return result;
}

}  // namespace

FrameRing create_frame_ring(const Device& device) {
  FrameRing ring;
  ring.timeline = create_semaphore(device, VK_SEMAPHORE_TYPE_TIMELINE);
  for (FrameSlot& slot : ring.slots) {
    VkCommandPoolCreateInfo pool_info = vk_struct<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool_info.queueFamilyIndex = device.queue_family;
    VkCommandPool pool = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device.handle, &pool_info, nullptr, &pool), "vkCreateCommandPool");
    slot.pool = {device.handle, pool, vkDestroyCommandPool};
    VkCommandBufferAllocateInfo info = vk_struct<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    info.commandPool = pool;
    info.commandBufferCount = 1;
    check(vkAllocateCommandBuffers(device.handle, &info, &slot.commands), "vkAllocateCommandBuffers");
    slot.acquired = create_semaphore(device, VK_SEMAPHORE_TYPE_BINARY);
  }
  return ring;
}

FrameSlot& begin_frame(const Device& device, FrameRing& ring) {
  ++ring.number;
  if (ring.number > FrameRing::kSlots) check(wait_for(device, ring, ring.number - FrameRing::kSlots), "vkWaitSemaphores");
  FrameSlot& slot = ring.slots[ring.slot_index()];
  check(vkResetCommandPool(device.handle, slot.pool, 0), "vkResetCommandPool");
  VkCommandBufferBeginInfo begin = vk_struct<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(slot.commands, &begin), "vkBeginCommandBuffer");
  return slot;
}

void submit_frame(const Device& device, FrameRing& ring, VkSemaphore present_from, VkSemaphore present_to) {
  const FrameSlot& slot = ring.slots[ring.slot_index()];
  check(vkEndCommandBuffer(slot.commands), "vkEndCommandBuffer");
  VkCommandBufferSubmitInfo commands = vk_struct<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
  commands.commandBuffer = slot.commands;
  VkSemaphoreSubmitInfo wait = vk_struct<VkSemaphoreSubmitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO);
  wait.semaphore = present_from;
  wait.stageMask = VK_PIPELINE_STAGE_2_BLIT_BIT;  // the first use of the swapchain image
  std::array<VkSemaphoreSubmitInfo, 2> signals{};
  signals[0].sType = signals[1].sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
  signals[0].semaphore = ring.timeline;
  signals[0].value = ring.number;
  signals[0].stageMask = signals[1].stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  signals[1].semaphore = present_to;
  VkSubmitInfo2 submit = vk_struct<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
  submit.waitSemaphoreInfoCount = present_from ? 1 : 0;
  submit.pWaitSemaphoreInfos = &wait;
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &commands;
  submit.signalSemaphoreInfoCount = present_to ? 2 : 1;
  submit.pSignalSemaphoreInfos = signals.data();
  check(vkQueueSubmit2(device.queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit2");
  ring.submitted = ring.number;
}

std::uint64_t completed_frame(const Device& device, const FrameRing& ring) {
  std::uint64_t value = 0;
  check(vkGetSemaphoreCounterValue(device.handle, ring.timeline, &value), "vkGetSemaphoreCounterValue");
  return value;
}

void finish_frames(const Device& device, const FrameRing& ring) noexcept {
  wait_for(device, ring, ring.submitted);
  vkDeviceWaitIdle(device.handle);
}

void wait_for_frames(const Device& device, const FrameRing& ring) {
  check(wait_for(device, ring, ring.submitted), "vkWaitSemaphores");
}

}  // namespace forest
