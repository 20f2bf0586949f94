#pragma once

#include <array>
#include <cstdint>

#include "frames.h"

namespace forest {

/// What the demo itself draws, in order. Between shadows and plants the library culls the picture's views and times that itself.
enum class ScenePass : std::uint8_t { shadows, plants, light, ground, tufts, sky, tone_map, temporal, count };
using SceneTimes = std::array<float, static_cast<std::size_t>(ScenePass::count)>;  ///< ms

/// Time stamps between the demo's passes. A stamp waits for what came before it: frames with stamps take longer.
struct PassTimer {
  const Device& device;
  Handle<VkQueryPool> pool;
  float tick_ms = 0;
  std::array<bool, FrameRing::kSlots> written = {};
  SceneTimes times = {};  ///< times of the frame that used the current slot before

  explicit PassTimer(const Device& device);
};

/// Reads what the slot's previous frame has measured, then stamps the start. timer may be null, here and below.
void start_timer(PassTimer* timer, VkCommandBuffer commands, std::size_t slot);
/// Everything since the last stamp was spent on `pass`; passes in order, each once.
/// start_plants comes between shadows and plants: what the library did meanwhile counts to neither.
void stamp_pass(PassTimer* timer, VkCommandBuffer commands, std::size_t slot, ScenePass pass);
void start_plants(PassTimer* timer, VkCommandBuffer commands, std::size_t slot);

}  // namespace forest
