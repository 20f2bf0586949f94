#include "eye_motion.h"

#include <algorithm>
#include <cmath>

#include "check.h"

namespace coppice {

namespace {

using Vector = std::array<float, 3>;

/// Steps differ by at most this share of the longer where the camera goes on as it did.
constexpr float kSteadyShare = 0.25f;

Vector difference(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

float length(const Vector& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

}  // namespace

std::array<float, 3> follow_eye(EyeMotion& motion, const std::array<float, 3>& eye_m, float frames) {
  const Vector last_m = motion.step_m;
  motion.step_m = difference(eye_m, motion.eye_m);
  motion.eye_m = eye_m;
  motion.frame_count = std::min(motion.frame_count + 1, 3u);
  const float longer_m = std::max(length(motion.step_m), length(last_m));
  const bool steady = motion.frame_count == 3 && length(difference(motion.step_m, last_m)) <= kSteadyShare * longer_m;
  if (!steady || longer_m == 0.0f) return {};
  return {frames * motion.step_m[0], frames * motion.step_m[1], frames * motion.step_m[2]};
}

DemandView moved_view(const DemandView& view, const std::array<float, 3>& by_m) {
  DemandView moved = view;
  for (std::size_t axis = 0; axis < 3; ++axis) moved.lod.eye_m[axis] += by_m[axis];
  for (auto& plane : moved.planes) plane[3] -= plane[0] * by_m[0] + plane[1] * by_m[1] + plane[2] * by_m[2];
  return moved;
}

void merge_demands(std::span<PlantDemand> demands, std::span<const PlantDemand> others) {
  COPPICE_ASSERT(demands.size() == others.size());
  for (std::size_t i = 0; i < demands.size(); ++i) {
    demands[i].max_size_px = std::max(demands[i].max_size_px, others[i].max_size_px);
    for (std::uint32_t bin = 0; bin < kSizeBinCount; ++bin)
      demands[i].instances[bin] = std::max(demands[i].instances[bin], others[i].instances[bin]);
  }
}

}  // namespace coppice
