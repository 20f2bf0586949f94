#include "frame_pace.h"

#include <algorithm>

namespace forest {
namespace {

constexpr float kFirstBudget = 250'000;
constexpr float kLeastBudget = 10'000;
constexpr float kMostBudget = 1e8f;
// A budget takes some frames to show in their time.
constexpr float kShareOfNewest = 0.15f;
constexpr float kFastestFall = 0.95f;
constexpr float kFastestRise = 1.02f;
constexpr float kRest = 0.9f;

}  // namespace

FramePace make_pace(float aim_ms, std::uint32_t leaf_budget) {
  const bool starts = aim_ms > 0 && leaf_budget == 0;
  return {.aim_ms = aim_ms, .budget = starts ? kFirstBudget : static_cast<float>(leaf_budget)};
}

std::uint32_t next_budget(FramePace& pace, float frame_ms, bool limited) {
  if (pace.aim_ms > 0 && frame_ms > 0) {
    pace.mean_ms += (frame_ms - pace.mean_ms) * (pace.mean_ms > 0 ? kShareOfNewest : 1.0f);
    const float share = pace.mean_ms / pace.aim_ms;
    if (share > 1)
      pace.budget *= std::max(1 / share, kFastestFall);
    else if (share < kRest && limited)
      pace.budget *= std::min(1 / share, kFastestRise);
    pace.budget = std::clamp(pace.budget, kLeastBudget, kMostBudget);
  }
  return static_cast<std::uint32_t>(pace.budget);
}

}  // namespace forest
