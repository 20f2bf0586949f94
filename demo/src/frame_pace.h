#pragma once

#include <cstdint>

namespace forest {

/// The leaf budget that keeps a frame's time near an aim.
struct FramePace {
  float aim_ms = 0;   ///< 0: the budget stays as it is
  float budget = 0;   ///< leaves
  float mean_ms = 0;  ///< of the last frames, the newest weigh most; 0: none yet
};

/// A pace that starts from `leaf_budget`, or where that is 0 from what a machine of some years draws in 33 ms.
FramePace make_pace(float aim_ms, std::uint32_t leaf_budget);
/// Takes a frame's time and returns the next one's budget. It moves by a few per cent a frame, down faster than up, and not at all within
/// a tenth below the aim. limited: the budget is what the threshold waits for; otherwise more of it would change nothing.
std::uint32_t next_budget(FramePace& pace, float frame_ms, bool limited);

}  // namespace forest
