#pragma once

// The geometric baseline: greedy leaf collapse by similarity (Deng, Zhang, Jaeger: Efficient Multiresolution of Foliage for Real-Time
// Rendering, PMA 2006; View-Dependent Hierarchical Foliage Simplification, 2007). The most similar pair of leaves, by distance, size and
// normal, is collapsed first; candidates come from a limited neighbourhood; no view is ever rendered. The botanical groups that those
// papers collapse first need a growth record that a mesh does not have.

#include "collapse.h"
#include "plant.h"
#include "progress.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

/// Mean of sqrt(area) of the quads, m: the size of a leaf. 0 without leaves.
double mean_leaf_size_m(const Foliage& foliage);

/// Dissimilarity of two leaves, the sum of three terms of equal weight:
///   distance  between centroids, in leaf sizes: |c1 - c2| / leaf_size_m (0 if that is 0)
///   size      |A1 - A2| / (A1 + A2), in [0, 1]; 0 when neither has area
///   normal    1 - |n1 . n2|, in [0, 1]; 1 when either has none. A leaf has no front.
/// leaf_size_m  mean_leaf_size_m of the source
double leaf_dissimilarity(const Quad& first, const Quad& second, double leaf_size_m);

/// Collapses to one leaf, always the least dissimilar pair among each leaf's 16 candidates (GreedyUnion). The new quad is the paper's Fig.
/// 3 (merge_corners). Ties go to the smaller ids. Runs on one thread. foliage   at least one leaf progress  may be empty
CollapseSequence collapse_by_similarity(const Foliage& foliage, const ProgressFunction& progress);

/// Measures a collapse sequence that was found without views: I(V,L) before it and at the levels of CollapseResult, from areas that are
/// exact at every step.
/// sequence  as many merges as bring the leaves down to one
/// errors    as render_item_buffers
Result<CollapseResult> replay(const ShownFoliage& shown, const std::vector<Viewpoint>& views, const CollapseOptions& options,
                              const CollapseSequence& sequence);

}  // namespace coppice::bake
