#pragma once

#include "collapse.h"
#include "incremental_image.h"
#include "plant.h"
#include "progress.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

/// The default metric: always does the cheapest collapse, down to one leaf. The cost of a collapse has three parts:
/// - its increase of the image's squared error against the source's (incremental_image.h);
/// - the colour that one leaf loses in the merged leaf of another, since the images are luminance;
/// - two priors for what no view shows: the mismatch between the pair and its merged leaf, both seen alone (pair_silhouette.h), and the
/// distance between the merged leaf's ends and those of the leaves that it replaces (leaf_reach.h).
///
/// A leaf looks for partners among the candidate_count nearest (LeafOctree), and among up to four times as many once merges have lost
/// coverage. For each partner it evaluates five shapes (pair_shapes), each with its best opacity, in some of the views, and remembers the
/// best three. When the cheapest of all is due, its cost is computed again in every view, since the image round it may have changed, and it
/// waits again if it is no longer the cheapest. Ties go to the smaller id, the smaller partner, the first shape. The result depends on the
/// arguments only, not on the number of threads.
/// result  source, levels: I(V,L) as in collapse_by_mutual_information, for these cuts
/// errors  as collapse_by_mutual_information
Result<CollapseResult> collapse_by_image_error(const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                               const CollapseOptions& options, const ImageErrorOptions& image_options,
                                               const ProgressFunction& progress);

}  // namespace coppice::bake
