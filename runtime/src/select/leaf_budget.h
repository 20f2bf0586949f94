#pragma once

// The error threshold at which a frame's work fits a budget. It is the same for all instances, so that a forest grows coarser evenly, and
// it follows what earlier frames drew, at the thresholds they drew it with: nothing waits for the GPU.

#include <array>
#include <cstddef>
#include <cstdint>

namespace coppice {

/// What a frame has drawn.
struct FrameWork {
  std::uint64_t frame = 0;
  std::uint64_t leaves = 0;
  std::uint64_t wood_triangles = 0;
  std::uint64_t hardware_triangles = 0;  ///< of leaves, leaf meshes and wood; those of the compute rasteriser are not in it
};

/// In leaves of the compute rasteriser, whose cost is the unit of a leaf budget.
double work_in_leaves(const FrameWork& work);

class LeafBudget {
 public:
  /// What a frame has drawn; frames that were seen before, or were not announced by threshold_px, are ignored.
  void observe(const FrameWork& work);
  /// The threshold for the next frame: at least error_px. Above it only while frames are beyond the budget; it moves by a bounded share
  /// a frame, and rests where the work is between kRest of the budget and all of it.
  /// frame  grows. error_px  > 0. budget  leaves; 0: none, and what has been learnt is forgotten
  float threshold_px(std::uint64_t frame, float error_px, std::uint32_t budget);

  static constexpr double kRest = 0.85;

 private:
  struct Used {
    std::uint64_t frame = 0;
    float log_threshold = 0;
  };
  static constexpr std::size_t kHistory = 16;

  std::array<Used, kHistory> used_{};  ///< by frame % kHistory
  std::uint64_t observed_frame_ = 0;
  std::uint32_t budget_ = 0;
  float log_threshold_ = 0;  ///< base 2, as those below
  float log_target_ = 0;
  bool active_ = false;  ///< the two are set
};

}  // namespace coppice
