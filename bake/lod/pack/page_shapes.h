#pragma once

#include <span>
#include <vector>

#include "page_model.h"
#include "tree.h"

namespace coppice::bake {

/// The shapes that enough of the quads have for a page to name them: the parallelogram, then up to three others, the most common first. A
/// shape is the place of corner 3 relative to the other three, so leaves of one model share it however they are placed.
std::vector<page_model::Shape> common_shapes(std::span<const QuantisedQuad> quads);

}  // namespace coppice::bake
