#pragma once

#include "collapse.h"
#include "live_image.h"
#include "plant.h"
#include "progress.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

/// The default metric: always the collapse that costs least, down to one leaf. Its cost is what it adds to the squared error of the
/// picture against the source's (live_image.h), what of its colour a leaf loses in a merged one of another, since pictures show luminance,
/// and two priors for what no view shows: the mismatch of the pair and its merged leaf seen alone (pair_silhouette.h), and how far what the
/// merged leaf stands for ends from it (leaf_reach.h).
///
/// A leaf looks for partners among the candidate_count nearest (LeafOctree), and up to four times as many where the merges so far have
/// lost cover. Each has five shapes (pair_shapes) with the best opacity of each, in one view of several; the best three are remembered. The
/// least of all is weighed anew in every view when its turn comes, since the picture round it may have changed, and waits again if it is no
/// longer the least. Ties go to the smaller id, the smaller partner, the first shape. The result depends on the arguments only, not on the
/// number of threads.
/// result  source, levels: I(V,L) as in collapse_by_mutual_information, of these cuts
/// errors  as collapse_by_mutual_information
Result<CollapseResult> collapse_by_image_error(const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                               const CollapseOptions& options, const ImageErrorOptions& image_options,
                                               const ProgressFunction& progress);

}  // namespace coppice::bake
