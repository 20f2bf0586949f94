#pragma once

// Predicts the camera's place, so that detail is requested before the camera arrives.

#include <cstdint>
#include <span>

#include "demand.h"
#include "hooks.h"
#include "ledger.h"

namespace coppice {

/// The eye from frame to frame.
struct EyeMotion {
  dvec3 eye_m{0, 0, 0};
  vec3 step_m{};
  std::uint32_t frame_count = 0;  ///< frames seen so far; a step takes two
};

/// Notes a frame's eye and returns how far the eye will move in `frames` frames, m. The result is 0 unless the last two steps are about the
/// same, so a camera that starts, stops, turns sharply or jumps is not followed.
vec3 follow_eye(EyeMotion& motion, const dvec3& eye_m, float frames);

/// The view after a move of the eye, in the same direction.
LodView moved_view(const LodView& view, const vec3& by_m);

/// Raises each demand to the maximum with another view's. Both are by plant index; others is at least as long (asserted).
void merge_demands(std::span<PlantDemand> demands, std::span<const PlantDemand> others);

/// The demand of the camera if its motion continues. A large scene is measured over several frames, a part of its blocks in each.
struct DemandAhead {
  EyeMotion motion;
  std::uint32_t unsteady_frames = 0;  ///< since the camera's motion was last steady
  LodView view;                       ///< the view that is being measured
  std::size_t next_block = 0;         ///< where the measurement continues; 0: there is none
  HookArray<PlantDemand> measured;    ///< the results so far; at least as long as the demands
  HookArray<PlantDemand> finished;    ///< the results of the measurement before; at least as long
  bool known = false;                 ///< `finished` holds a measurement
};

/// Number of blocks that a frame measures, or more if that would make more than kMaxAheadParts parts.
inline constexpr std::size_t kAheadBlocks = 4096;
inline constexpr std::size_t kMaxAheadParts = 8;
/// A frame that takes longer than its neighbours makes a step that differs from both; after a stop or a turn the steps keep differing.
inline constexpr std::uint32_t kHitchFrames = 2;

/// Reserves memory for the demands of this many plants, counted by the ledger. errors  out_of_memory; nothing has changed
Result<void> make_room(DemandAhead& ahead, const coppice_allocator& allocator, Ledger& ledger, std::uint32_t plant_count);

/// Notes a frame's view, continues to measure its demand in about `frames` frames, and raises demands to that. demands: by plant index;
/// memory is reserved
void add_demand_ahead(DemandAhead& ahead, const InstanceBlocks& instances, const LodView& view, float frames,
                      std::span<PlantDemand> demands);

/// Drops the measurements, because plant indices may mean other plants now.
void forget_demand(DemandAhead& ahead);

}  // namespace coppice
