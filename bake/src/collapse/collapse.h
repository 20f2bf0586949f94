#pragma once

#include <vector>

#include "plant.h"
#include "progress.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

inline constexpr std::uint32_t kMaxCandidateCount = 4096;

/// The paper's options. Defaults are the paper's where it gives them.
struct CollapseOptions {
  std::uint32_t resolution_px = 256;  ///< item buffers are square; 1 .. kMaxResolutionPx
  bool count_background = true;       ///< the background is one more outcome, a_t is the whole image; else a_t is the visible foliage
  std::uint32_t candidate_count = 8;  ///< N': least number of leaves the enlarged cell holds, see LeafOctree; 1 .. kMaxCandidateCount
};

/// I(V,L) and the number of leaves it is of. The background, where it counts, is one of the outcomes summed.
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

/// Algorithm 1 of the paper (mode `mi`), down to one leaf: while more than one is left, the leaf of least visibility I(V,l), eq. (8), is
/// collapsed with the candidate of least cost C_p, eq. (9). Ties go to the smaller id. Areas are exact at every step. The result
/// depends on the arguments only, not on the number of threads (limit it with tbb::global_control).
/// Visibility and cost are compared as integers, multiples of 2^-40 bits (mutual_information.h); candidates are LeafOctree's.
/// shown  of materials and images the alpha masks: masked texels are holes in the item buffers
/// progress  may be empty
/// errors  invalid_argument: an option out of range, no leaves, what render_item_buffers rejects
Result<CollapseResult> collapse_by_mutual_information(const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                                      const CollapseOptions& options, const ProgressFunction& progress);

/// The leaf counts of CollapseResult::levels for a plant of leaf_count >= 1 leaves.
std::vector<std::uint32_t> level_leaf_counts(std::uint32_t leaf_count);

}  // namespace coppice::bake
