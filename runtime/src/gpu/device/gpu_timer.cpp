#include "gpu_timer.h"

#include <span>

namespace coppice::gpu {

Result<void> GpuTimer::create(Device& device) {
  VkPhysicalDeviceProperties properties{};
  device.vk.vkGetPhysicalDeviceProperties(device.physical_device, &properties);
  if (!properties.limits.timestampComputeAndGraphics) {
    go_on_without(device, {Status::unsupported, "the device's queues have no timestamps"}, "pass_ms stays 0");
    return {};
  }
  tick_ns_ = properties.limits.timestampPeriod;
  const VkQueryPoolCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_TIMESTAMP, .queryCount = kSlots * kMarks};
  COPPICE_CHECK(check_created(device, device.vk.vkCreateQueryPool(device.device, &info, nullptr, &pool_), "vkCreateQueryPool", pool_));
  return {};
}

void GpuTimer::destroy(const Device& device) {
  device.vk.vkDestroyQueryPool(device.device, pool_, nullptr);
  pool_ = VK_NULL_HANDLE;
}

void GpuTimer::begin(const Device& device, VkCommandBuffer cmd, std::uint64_t frame, std::uint64_t completed_frame) {
  current_ = kSlots;
  for (std::uint32_t i = 0; i < kSlots; ++i)
    if (slots_[i].frame <= completed_frame) current_ = i;
  if (current_ == kSlots) return;
  slots_[current_] = {.frame = frame, .mark_count = 0, .passes = {}};
  device.vk.vkCmdResetQueryPool(cmd, pool_, current_ * kMarks, kMarks);
  stamp(device, cmd);
}

void GpuTimer::stamp(const Device& device, VkCommandBuffer cmd) {
  Slot& slot = slots_[current_];
  device.vk.vkCmdWriteTimestamp2(cmd, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_, current_ * kMarks + slot.mark_count);
  ++slot.mark_count;
  // Without it lavapipe takes the time only when a later command waits.
  memory_barrier(device, cmd, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                 VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
}

void GpuTimer::mark(const Device& device, VkCommandBuffer cmd, Pass pass) {
  if (current_ == kSlots || slots_[current_].mark_count == kMarks) return;
  slots_[current_].passes[slots_[current_].mark_count] = pass;
  stamp(device, cmd);
}

void GpuTimer::collect(Device& device, std::uint64_t completed_frame) {
  const Slot* newest = nullptr;
  for (const Slot& slot : slots_)
    if (slot.frame != 0 && slot.frame <= completed_frame && (newest == nullptr || slot.frame > newest->frame)) newest = &slot;
  if (newest == nullptr || newest->mark_count < 2) return;
  std::array<std::uint64_t, kMarks> ticks{};
  const auto first = static_cast<std::uint32_t>(newest - slots_.data()) * kMarks;
  const VkResult result =
      device.vk.vkGetQueryPoolResults(device.device, pool_, first, newest->mark_count, newest->mark_count * sizeof ticks[0], ticks.data(),
                                      sizeof ticks[0], VK_QUERY_RESULT_64_BIT);
  if (result == VK_NOT_READY) return;
  if (auto read = check(device, result, "vkGetQueryPoolResults"); !read)
    return go_on_without(device, read.error(), "pass_ms stays as it was");
  pass_ms_ = {};
  for (std::uint32_t i = 1; i < newest->mark_count; ++i)
    pass_ms_[static_cast<std::size_t>(newest->passes[i])] += static_cast<float>(ticks[i] - ticks[i - 1]) * tick_ns_ * 1e-6f;
}

}  // namespace coppice::gpu
