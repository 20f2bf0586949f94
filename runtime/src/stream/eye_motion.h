#pragma once

// Where the camera will be: what it wants there is asked for before it arrives.

#include <array>
#include <cstdint>
#include <span>

#include "demand.h"

namespace coppice {

/// The eye from frame to frame.
struct EyeMotion {
  std::array<float, 3> eye_m{}, step_m{};
  std::uint32_t frame_count = 0;  ///< seen so far; a step takes two
};

/// Takes in a frame's eye. returns  how far the eye will have moved, m, in `frames` frames: 0 unless the last two steps are about the same.
/// A camera that starts, stops, turns sharply or jumps is not followed.
std::array<float, 3> follow_eye(EyeMotion& motion, const std::array<float, 3>& eye_m, float frames);

/// The view from an eye that has moved, looking the same way.
DemandView moved_view(const DemandView& view, const std::array<float, 3>& by_m);

/// Raises each demand to what another view wants of the plant, where that is more. Both by plant index, of equal length (asserted).
void merge_demands(std::span<PlantDemand> demands, std::span<const PlantDemand> others);

}  // namespace coppice
