#pragma once

// Options and results of every collapse: collapse_image.h, collapse_information.h, collapse_geometric.h.

#include <algorithm>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kMaxCandidateCount = 4096;

/// The paper's options, with its defaults where it gives any.
struct CollapseOptions {
  std::uint32_t resolution_px = 256;  ///< item buffers are square; 1 .. kMaxResolutionPx
  bool count_background = true;       ///< the background is one more outcome and a_t is the whole image; else a_t is the visible foliage
  std::uint32_t candidate_count = 8;  ///< N': minimum number of leaves in the enlarged cell, see LeafOctree; 1 .. kMaxCandidateCount
};

/// I(V,L) of so many leaves. The background, if it counts, is one of the outcomes summed.
struct FoliageInformation {
  std::uint32_t leaf_count = 0;
  double bits = 0.0;
};

struct CollapseResult {
  CollapseSequence sequence;
  FoliageInformation source;               ///< before the first collapse
  std::vector<FoliageInformation> levels;  ///< at floor(f N), at least 1, for f = .8 .6 .4 .2 .1 .05 .025, in that order
  double visibility_seconds = 0.0;         ///< item buffers, before the first collapse
};

/// errors  invalid_argument: a number of candidates that is out of range
inline Result<void> check_candidate_count(const CollapseOptions& options) {
  if (options.candidate_count >= 1 && options.candidate_count <= kMaxCandidateCount) return {};
  return Error{Status::invalid_argument, "number of candidates is not between 1 and 4096", Error::kNoOffset,
               std::to_string(options.candidate_count)};
}

/// The leaf counts of CollapseResult::levels for a plant of leaf_count >= 1 leaves.
inline std::vector<std::uint32_t> level_leaf_counts(std::uint32_t leaf_count) {
  std::vector<std::uint32_t> counts;
  for (const std::uint64_t thousandths : {800u, 600u, 400u, 200u, 100u, 50u, 25u})
    counts.push_back(std::max(1u, static_cast<std::uint32_t>(leaf_count * thousandths / 1000)));
  return counts;
}

}  // namespace coppice::bake
