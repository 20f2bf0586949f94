#pragma once

#include <functional>
#include <vector>

#include "plant.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

/// The paper's options. Defaults are the paper's where it gives them.
struct CollapseOptions {
  std::uint32_t resolution_px = 256;    ///< item buffers are square
  bool count_background = true;         ///< the background is one more outcome, a_t is the whole image
  std::uint32_t candidate_count = 8;    ///< N': the octree cell grows until it holds at least so many other leaves
};

/// I(V,L) and the number of leaves it is of.
struct FoliageInformation {
  std::uint32_t leaf_count = 0;
  double bits = 0.0;
};

struct CollapseResult {
  CollapseSequence sequence;
  FoliageInformation source;                ///< before the first collapse
  std::vector<FoliageInformation> levels;   ///< at floor(f N) for f = .8 .6 .4 .2 .1 .05 .025, in that order
  double visibility_seconds = 0.0;
};

/// Called from the calling thread, with a fraction in [0, 1] that never falls.
using ProgressFunction = std::function<void(double fraction)>;

/// Algorithm 1 of the paper (mode `mi`), down to one leaf: while more than one is left, the leaf of least visibility I(V,l), eq. (8), is
/// collapsed with the candidate of least cost C_p, eq. (9). Ties go to the smaller id. Areas are exact at every step. The result
/// depends on the arguments only, not on the number of threads.
/// materials, images  alpha masks of the cards: masked texels are holes in the item buffers
/// errors  invalid_argument: an option out of range, no leaves
Result<CollapseResult> collapse_by_mutual_information(const Foliage& foliage, const std::vector<Material>& materials,
                                                      const std::vector<Image>& images, const std::vector<Viewpoint>& views,
                                                      const CollapseOptions& options, const ProgressFunction& progress);

}  // namespace coppice::bake
