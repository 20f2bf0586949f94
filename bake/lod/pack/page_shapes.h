#pragma once

#include <span>
#include <vector>

#include "page_model.h"
#include "tree.h"

namespace coppice::bake {

/// The shapes that enough of the quads have for a page to name them: the parallelogram, then up to three others, the commonest first. A
/// shape is where corner 3 is in terms of the other three, so leaves of one model share it however they are placed.
std::vector<page_model::Shape> common_shapes(std::span<const QuantisedQuad> quads);

}  // namespace coppice::bake
