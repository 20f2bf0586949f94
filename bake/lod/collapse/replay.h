#pragma once

#include "collapse.h"
#include "plant.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

/// Measures a collapse sequence that was found without views: I(V,L) before it and at the levels of CollapseResult, from areas that are
/// exact at every step.
/// sequence  as many merges as bring the leaves down to one
/// errors    as render_item_buffers
Result<CollapseResult> replay(const ShownFoliage& shown, const std::vector<Viewpoint>& views, const CollapseOptions& options,
                              const CollapseSequence& sequence);

}  // namespace coppice::bake
