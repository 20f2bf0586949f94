#include "eye_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

void add_demand_ahead(DemandAhead& ahead, const InstanceBlocks& instances, const DemandView& view, float frames,
                      std::span<PlantDemand> demands) {
  COPPICE_ASSERT(ahead.measured.size() == demands.size());
  const std::size_t blocks = instances.bounds.size();
  const std::size_t part_blocks = std::max(kAheadBlocks, (blocks + kMostAheadParts - 1) / kMostAheadParts);
  const std::size_t parts = std::max<std::size_t>((blocks + part_blocks - 1) / part_blocks, 1);
  // It is done parts - 1 frames after its view, and of use for as many frames as the next one takes.
  const float age = 1.5f * static_cast<float>(parts - 1);
  const Vector by_m = follow_eye(ahead.motion, view.lod.eye_m, frames > 0.0f ? frames + age : 0.0f);
  const bool steady = by_m != Vector{};
  ahead.unsteady_frames = steady ? 0 : ahead.unsteady_frames + 1;
  if (ahead.unsteady_frames > kHitchFrames) return forget_demand(ahead);
  if (steady && ahead.next_block == 0) {
    ahead.view = moved_view(view, by_m);
    std::ranges::fill(ahead.measured, PlantDemand{});
  }
  if (steady || ahead.next_block > 0) {
    add_demand(instances, ahead.next_block, ahead.next_block + part_blocks, ahead.view, ahead.measured);
    ahead.next_block += part_blocks;
  }
  if (ahead.next_block > 0 && ahead.next_block >= blocks) {
    std::swap(ahead.measured, ahead.finished);
    ahead.next_block = 0;
    ahead.known = true;
  }
  if (ahead.known) merge_demands(demands, ahead.finished);
}

void forget_demand(DemandAhead& ahead) {
  ahead.next_block = 0;
  ahead.known = false;
}

}  // namespace coppice
