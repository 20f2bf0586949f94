#pragma once

#include <algorithm>

namespace forest {

/// What keeps a frame's time near an aim: how many of the picture's pixels are drawn, and where that is not enough how many leaves.
struct FramePace {
  float aim_ms = 0;    ///< 0: all stays as it is
  float scale = 1;     ///< share of the picture's width and height that is drawn
  bool scales = true;  ///< whether `scale` may change
  float budget = 0;    ///< leaves; 0: any number
  float mean_ms = 0;   ///< mean of the last frames, weighted to the newest; 0: none yet
};

/// Fewer pixels than this share squared show no forest any more.
constexpr float kLeastScale = 0.25f;

/// Takes a frame's time, ms. Scale and budget move by a few per cent a frame, down faster than up, and not at all within a tenth below the
/// aim. limited: the budget is what the threshold waits for; otherwise more of it would change nothing.
void keep_pace(FramePace& pace, float frame_ms, bool limited);

/// When the next frame may start, so that there is at most one every `period`: a period after `last`, the start of the one before, or now
/// where that is later.
template <class Time, class Duration>
Time next_start(Time last, Time now, Duration period) {
  return std::max(last + period, now);
}

/// `scale` in steps, so that images are not of a new size in every frame.
float stepped_scale(const FramePace& pace);

}  // namespace forest
