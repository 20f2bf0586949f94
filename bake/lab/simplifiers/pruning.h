#pragma once

// Simplifiers that leave leaves out and let others grow to make up for them.

#include <cstdint>
#include <vector>

#include "collapse.h"
#include "plant.h"
#include "progress.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

/// Scales the quad about its centroid (the mean of its corners), so that its area grows by factor^2.
Quad scaled_quad(const Quad& quad, double factor);

/// 0 .. leaf_count - 1 in random order, the same for the same count and seed.
std::vector<std::uint32_t> stochastic_order(std::uint32_t leaf_count, std::uint64_t seed);

/// The stochastic baseline (Cook, Halstead, Planck, Ryu: Stochastic Simplification of Aggregate Detail, SIGGRAPH 2007): keeps the first
/// kept_count leaves of stochastic_order, in leaf order, each scaled about its centroid so that the total area stays.
/// kept_count  1 .. leaf_count (asserted)
Foliage prune_stochastically(const Foliage& foliage, std::uint32_t kept_count, std::uint64_t seed);

/// One step of the pruning by mutual information: the source leaf that goes and the one that grows.
struct PruneStep {
  std::uint32_t pruned = 0, grown = 0;
};

struct PruneResult {
  std::vector<PruneStep> steps;
  std::vector<Foliage> levels;  ///< [leaf_counts.size()], leaves in source order
};

/// The pruning baseline (Gasch, Remolar, Chover, Rebollo: Viewpoint-Driven Simplification of Plant and Tree Foliage, Entropy 20(4) 213,
/// 2018): prunes leaves one by one. The live leaf with the smallest visibility I(V,l), eq. (8), goes (of equals the smaller source leaf).
/// The remaining leaf with the nearest centroid (of equals the smaller) is scaled about its centroid until its area is the sum of both. A
/// leaf without area stays as it is. Visibility is exact after every step.
/// leaf_counts  any order; each 1 .. shown.foliage.leaf_count() (asserted). Pruning stops at the smallest.
/// options      resolution and background; there are no candidates
/// progress     may be empty
/// errors       those of render_item_buffers
Result<PruneResult> prune_by_mutual_information(const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                                const CollapseOptions& options, const std::vector<std::uint32_t>& leaf_counts,
                                                const ProgressFunction& progress);

}  // namespace coppice::bake
