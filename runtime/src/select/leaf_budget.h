#pragma once

// Finds the error threshold at which a frame's work fits a budget. It is the same for all instances, so a forest grows coarser evenly. It
// follows the counts of earlier frames and their thresholds, so nothing waits for the GPU.

#include <array>
#include <cstddef>
#include <cstdint>

namespace coppice {

/// The work of a frame.
struct FrameWork {
  std::uint64_t frame = 0;
  std::uint64_t leaves = 0;
  std::uint64_t wood_triangles = 0;
  std::uint64_t hardware_triangles = 0;  ///< triangles of leaves, leaf meshes and wood, without those of the compute rasteriser
};

/// Converts work to leaves of the compute rasteriser, the unit of a leaf budget.
double work_in_leaves(const FrameWork& work);

class LeafBudget {
 public:
  /// Learns from the work of a frame. It ignores frames that it has seen, and frames for which threshold_px was not called.
  void observe(const FrameWork& work);
  /// Returns the threshold for the next frame, at least error_px. It is above error_px only while frames exceed the budget. It moves by a
  /// bounded share a frame, and rests while the work is between kRest of the budget and all of it.
  /// frame  grows. error_px  > 0. budget  leaves; 0: no budget, and what was learnt is forgotten
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
  bool active_ = false;  ///< the two above are set
};

}  // namespace coppice
