#include "frame_pace.h"

#include <algorithm>
#include <cmath>

namespace forest {
namespace {

constexpr float kFirstBudget = 250'000;  // where any number was allowed
constexpr float kMinBudget = 100'000;    // with fewer leaves they get so large that their pixels cost what their number saves
constexpr float kMaxBudget = 1e8f;
constexpr float kScaleSteps = 32;
// What changes takes some frames to show in their time.
constexpr float kShareOfNewest = 0.15f;
constexpr float kFastestFall = 0.95f;
constexpr float kFastestRise = 1.02f;
constexpr float kRest = 0.9f;

}  // namespace

void keep_pace(FramePace& pace, float frame_ms, bool limited) {
  if (pace.aim_ms <= 0 || frame_ms <= 0) return;
  pace.mean_ms += (frame_ms - pace.mean_ms) * (pace.mean_ms > 0 ? kShareOfNewest : 1.0f);
  const float share = pace.mean_ms / pace.aim_ms;
  if (share <= 1 && share >= kRest) return;
  const float factor = std::clamp(1 / share, kFastestFall, kFastestRise);
  // Time goes with pixels, which are the scale squared.
  if (pace.scales && (share > 1 ? pace.scale > kLeastScale : !limited)) {
    pace.scale = std::clamp(pace.scale * std::sqrt(factor), kLeastScale, 1.0f);
  } else if (share > 1 || limited) {
    pace.budget = std::clamp((pace.budget > 0 ? pace.budget : kFirstBudget) * factor, kMinBudget, kMaxBudget);
  }
}

float stepped_scale(const FramePace& pace) {
  return pace.scales ? std::round(kScaleSteps * pace.scale) / kScaleSteps : pace.scale;
}

}  // namespace forest
