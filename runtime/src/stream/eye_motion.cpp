#include "eye_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "check.h"

namespace coppice {

namespace {

/// Maximum difference of two steps of a steady camera, as a share of the longer one.
constexpr float kSteadyShare = 0.25f;
/// Capacity for plants from the start.
constexpr std::uint32_t kFirstMoved = 64;

}  // namespace

vec3 follow_eye(EyeMotion& motion, const dvec3& eye_m, float frames) {
  const vec3 last_m = motion.step_m;
  motion.step_m = (eye_m - motion.eye_m).rounded();
  motion.eye_m = eye_m;
  motion.frame_count = std::min(motion.frame_count + 1, 3u);
  const float longer_m = std::max(length(motion.step_m), length(last_m));
  const bool steady = motion.frame_count == 3 && distance(motion.step_m, last_m) <= kSteadyShare * longer_m;
  return steady ? frames * motion.step_m : vec3(0.0f);
}

LodView moved_view(const LodView& view, const vec3& by_m) {
  LodView moved = view;
  moved.eye_m = moved.eye_m + dvec3(by_m);
  return moved;
}

void merge_demands(std::span<PlantDemand> demands, std::span<const PlantDemand> others) {
  COPPICE_ASSERT(demands.size() <= others.size());
  for (std::size_t i = 0; i < demands.size(); ++i) {
    demands[i].max_size_px = std::max(demands[i].max_size_px, others[i].max_size_px);
    for (std::uint32_t bin = 0; bin < kSizeBinCount; ++bin)
      demands[i].instances[bin] = std::max(demands[i].instances[bin], others[i].instances[bin]);
  }
}

Result<void> make_room(DemandAhead& ahead, const coppice_allocator& allocator, Ledger& ledger, std::uint32_t plant_count) {
  const auto now = static_cast<std::uint32_t>(ahead.measured.size());
  if (plant_count <= now) return {};
  const std::uint32_t count = roomy_count({.now = now, .needed = plant_count, .first = kFirstMoved, .maximum = UINT32_MAX});
  COPPICE_TRY(measured, enlarged_copy(ahead.measured, allocator, count));
  COPPICE_TRY(finished, enlarged_copy(ahead.finished, allocator, count));
  ahead.measured = std::move(measured);
  ahead.finished = std::move(finished);
  ledger.reserve(std::uint64_t{2} * (count - now) * sizeof(PlantDemand));
  return {};
}

void add_demand_ahead(DemandAhead& ahead, const InstanceBlocks& instances, const LodView& view, float frames,
                      std::span<PlantDemand> demands) {
  COPPICE_ASSERT(demands.size() <= ahead.measured.size());
  const std::size_t blocks = instances.bounds.size();
  const std::size_t part_blocks = std::max(kAheadBlocks, (blocks + kMaxAheadParts - 1) / kMaxAheadParts);
  const std::size_t parts = std::max<std::size_t>((blocks + part_blocks - 1) / part_blocks, 1);
  // The measurement is complete parts - 1 frames after its view, and used for as many frames as the next one takes.
  const float age = 1.5f * static_cast<float>(parts - 1);
  const vec3 by_m = follow_eye(ahead.motion, view.eye_m, frames > 0.0f ? frames + age : 0.0f);
  const bool steady = by_m != vec3(0.0f);
  ahead.unsteady_frames = steady ? 0 : ahead.unsteady_frames + 1;
  if (ahead.unsteady_frames > kHitchFrames) return forget_demand(ahead);
  if (steady && ahead.next_block == 0) {
    ahead.view = moved_view(view, by_m);
    std::ranges::fill(ahead.measured.span(), PlantDemand{});
  }
  if (steady || ahead.next_block > 0) {
    add_demand(instances, ahead.next_block, ahead.next_block + part_blocks, ahead.view, ahead.measured.span());
    ahead.next_block += part_blocks;
  }
  if (ahead.next_block > 0 && ahead.next_block >= blocks) {
    std::swap(ahead.measured, ahead.finished);
    ahead.next_block = 0;
    ahead.known = true;
  }
  if (ahead.known) merge_demands(demands, ahead.finished.span());
}

void forget_demand(DemandAhead& ahead) {
  ahead.next_block = 0;
  ahead.known = false;
}

}  // namespace coppice
