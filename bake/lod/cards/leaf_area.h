#pragma once

#include "plant.h"

namespace coppice::bake {

/// Ratio of the area that a leaf covers on screen to that of its card: the mean area of the leaf's outline over directions, divided by the
/// area of its outline in the quad's plane. A leaf that is bent, folded or has volume shows something even where a card is seen edge-on. At
/// least 1; 1 for a flat leaf.
/// quad  a rectangle that holds the leaf
double fullness(const Plant& plant, const LeafRange& leaf, const Quad& quad);

}  // namespace coppice::bake
