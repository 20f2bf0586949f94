#pragma once

#include "collapse.h"

namespace coppice::bake {

/// The result of a collapse sequence that was found without looking: I(V,L) before it and at the levels of CollapseResult, from areas that
/// are exact at every step. sequence  foliage.leaf_count() - 1 merges down to one leaf errors    as render_item_buffers
Result<CollapseResult> replay(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                              const std::vector<Viewpoint>& views, const CollapseOptions& options, const CollapseSequence& sequence);

}  // namespace coppice::bake
