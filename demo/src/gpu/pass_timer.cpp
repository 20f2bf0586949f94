#include "pass_timer.h"

#include "failure.h"
#include "vk_struct.h"

namespace forest {
namespace {

// At 0 the frame starts, 1 ends the shadows, at 2 the plants start; from there on each ends a pass.
constexpr auto kStamps = static_cast<std::uint32_t>(ScenePass::count) + 2;

std::uint32_t end_of(std::size_t pass) {
  return static_cast<std::uint32_t>(pass == static_cast<std::size_t>(ScenePass::shadows) ? 1 : pass + 2);
}

void stamp(const PassTimer& timer, VkCommandBuffer commands, std::size_t slot, std::uint32_t index) {
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, timer.pool, static_cast<std::uint32_t>(slot) * kStamps + index);
}

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
    for (std::size_t i = 0; i < timer->times.size(); ++i)
      timer->times[i] = timer->tick_ms * static_cast<float>(ticks[end_of(i)] - ticks[end_of(i) - 1]);
  }
  timer->written[slot] = true;
  vkCmdResetQueryPool(commands, timer->pool, first, kStamps);
  stamp(*timer, commands, slot, 0);
}

void stamp_pass(PassTimer* timer, VkCommandBuffer commands, std::size_t slot, ScenePass pass) {
  if (timer != nullptr) stamp(*timer, commands, slot, end_of(static_cast<std::size_t>(pass)));
}

void start_plants(PassTimer* timer, VkCommandBuffer commands, std::size_t slot) {
  if (timer != nullptr) stamp(*timer, commands, slot, 2);
}

}  // namespace forest
