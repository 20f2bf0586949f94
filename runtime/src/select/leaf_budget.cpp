#include "leaf_budget.h"

#include <algorithm>
#include <cmath>

namespace coppice {
namespace {

// Measured on lavapipe. On other devices a budget has to be tuned anyway.
constexpr double kHardwareTriangleLeaves = 4.0;
/// The number of leaves falls about as the threshold's power of -1 to -2. Each frame goes less than the whole way, so that neither
/// overshoots.
constexpr float kGain = 0.6f;
/// Octaves a frame. It rises within some frames of meeting a thicket, and falls too slowly to be seen.
constexpr float kFastestRise = 0.25f;
constexpr float kFastestFall = 0.04f;
/// 32 px. Beyond that little is saved, and plants lose their shape.
constexpr float kHighestLog = 5.0f;
/// The share of the budget that is aimed at from both sides, because the budget itself would only be reached in the limit.
constexpr double kAim = 0.93;

}  // namespace

double work_in_leaves(const FrameWork& work) {
  return static_cast<double>(work.leaves) + static_cast<double>(work.wood_triangles) +
         kHardwareTriangleLeaves * static_cast<double>(work.hardware_triangles);
}

void LeafBudget::observe(const FrameWork& work) {
  const Used& used = used_[work.frame % kHistory];
  if (!active_ || work.frame <= observed_frame_ || used.frame != work.frame) return;
  observed_frame_ = work.frame;
  const double share = std::max(work_in_leaves(work) / static_cast<double>(budget_), 1.0 / 64.0);
  // A threshold that fits stays where it is now, not where it was when it was found to fit.
  log_target_ = log_threshold_;
  if (share > 1.0 || share < kRest) log_target_ = used.log_threshold + kGain * static_cast<float>(std::log2(share / kAim));
}

float LeafBudget::threshold_px(std::uint64_t frame, float error_px, std::uint32_t budget) {
  const float lowest_log = std::log2(error_px);
  if (budget == 0) {
    *this = {};
    return error_px;
  }
  if (!active_) log_threshold_ = log_target_ = lowest_log;
  active_ = true;
  budget_ = budget;
  log_target_ = std::clamp(log_target_, lowest_log, std::max(lowest_log, kHighestLog));
  log_threshold_ = std::max(log_threshold_ + std::clamp(log_target_ - log_threshold_, -kFastestFall, kFastestRise), lowest_log);
  used_[frame % kHistory] = {frame, log_threshold_};
  return log_threshold_ > lowest_log ? std::exp2(log_threshold_) : error_px;
}

}  // namespace coppice
