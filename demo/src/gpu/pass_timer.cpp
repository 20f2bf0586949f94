#include "pass_timer.h"

#include "failure.h"
#include "vk_struct.h"

namespace forest {
namespace {

constexpr auto kStamps = static_cast<std::uint32_t>(ScenePass::count) + 1;

}  // namespace

PassTimer::PassTimer(const Device& device_in) : device(device_in) {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(device.physical, &properties);
  tick_ms = 1e-6f * properties.limits.timestampPeriod;
  VkQueryPoolCreateInfo info = vk_struct<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = kStamps * static_cast<std::uint32_t>(FrameRing::kSlots);
  VkQueryPool created = VK_NULL_HANDLE;
  check(vkCreateQueryPool(device.handle, &info, nullptr, &created), "vkCreateQueryPool");
  pool = {device.handle, created, vkDestroyQueryPool};
}

void start_timer(PassTimer* timer, VkCommandBuffer commands, std::size_t slot) {
  if (timer == nullptr) return;
  const std::uint32_t first = static_cast<std::uint32_t>(slot) * kStamps;
  std::array<std::uint64_t, kStamps> ticks{};
  if (timer->written[slot]) {
    check(vkGetQueryPoolResults(timer->device.handle, timer->pool, first, kStamps, sizeof ticks, ticks.data(), sizeof ticks[0],
                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "vkGetQueryPoolResults");
    for (std::size_t i = 0; i < timer->times.size(); ++i) timer->times[i] = timer->tick_ms * static_cast<float>(ticks[i + 1] - ticks[i]);
  }
  timer->written[slot] = true;
  vkCmdResetQueryPool(commands, timer->pool, first, kStamps);
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, timer->pool, first);
}

void stamp_pass(PassTimer* timer, VkCommandBuffer commands, std::size_t slot, ScenePass pass) {
  if (timer == nullptr) return;
  const std::uint32_t first = static_cast<std::uint32_t>(slot) * kStamps;
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, timer->pool, first + static_cast<std::uint32_t>(pass) + 1);
}

}  // namespace forest
