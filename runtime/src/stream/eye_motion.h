#pragma once

// Where the camera will be: what it wants there is asked for before it arrives.

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
  std::uint32_t frame_count = 0;  ///< seen so far; a step takes two
};

/// Takes in a frame's eye. returns  how far the eye will have moved, m, in `frames` frames: 0 unless the last two steps are about the same.
/// A camera that starts, stops, turns sharply or jumps is not followed.
vec3 follow_eye(EyeMotion& motion, const dvec3& eye_m, float frames);

/// The view from an eye that has moved, looking the same way.
LodView moved_view(const LodView& view, const vec3& by_m);

/// Raises each demand to what another view wants of the plant, where that is more. Both by plant index, others as long at least (asserted).
void merge_demands(std::span<PlantDemand> demands, std::span<const PlantDemand> others);

/// What the camera will want if it goes on as it does. A large scene is measured over some frames, a part of its blocks in each.
struct DemandAhead {
  EyeMotion motion;
  std::uint32_t unsteady_frames = 0;  ///< since the camera last went on as it did
  LodView view;                       ///< of the measurement under way
  std::size_t next_block = 0;         ///< it goes on with; 0: none is under way
  HookArray<PlantDemand> measured;    ///< by it so far; as long as the demands, or longer
  HookArray<PlantDemand> finished;    ///< by the one before, likewise
  bool known = false;                 ///< there is one before
};

/// Blocks that a frame measures: so many, or more where there would be more than kMostAheadParts parts.
inline constexpr std::size_t kAheadBlocks = 4096;
inline constexpr std::size_t kMostAheadParts = 8;
/// A frame that takes longer than its neighbours is a step that differs from both; a camera that has stopped or turned goes on differing.
inline constexpr std::uint32_t kHitchFrames = 2;

/// Makes room for the demands of so many plants, which the ledger counts. errors  out_of_memory; nothing has changed
Result<void> make_room(DemandAhead& ahead, const coppice_allocator& allocator, Ledger& ledger, std::uint32_t plant_count);

/// Takes in a frame's view, goes on measuring what it will want in about `frames` frames, and raises demands (by plant index; there is room
/// for them) to that.
void add_demand_ahead(DemandAhead& ahead, const InstanceBlocks& instances, const LodView& view, float frames,
                      std::span<PlantDemand> demands);

/// Drops what has been measured, whose plant indices may mean others now.
void forget_demand(DemandAhead& ahead);

}  // namespace coppice
