#pragma once

#include "area_request.h"
#include "collapse.h"
#include "plant.h"
#include "progress.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

/// Says who measures projected areas: by default item buffers.
struct AreaSource {
  MeasureAreas measure = {};
  /// Measures again after each merge and for each merge whose cost is computed, with N_l + 1 passes a view: for small plants. Otherwise
  /// measures only before the first merge; then item buffers say how areas change.
  bool every_step = false;
};

/// Algorithm 1 of the paper (mode `mi`), down to one leaf: takes the leaf with the smallest visibility I(V,l), eq. (8), and collapses it
/// with the candidate with the smallest cost C_p, eq. (9). Ties go to the smaller id. Areas are exact at every step. The result depends on
/// the arguments only, not on the number of threads (limit it with tbb::global_control). Visibility and cost are compared as integers,
/// multiples of 2^-40 bits (mutual_information.h); candidates are LeafOctree's.
/// shown     only the alpha masks of materials and images count: masked texels are holes in the item buffers
/// progress  may be empty
/// errors  invalid_argument: an option out of range, no leaves, what render_item_buffers rejects; those of areas.measure
Result<CollapseResult> collapse_by_mutual_information(const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                                      const CollapseOptions& options, const ProgressFunction& progress,
                                                      const AreaSource& areas = {});

}  // namespace coppice::bake
