#pragma once

#include "plant.h"

namespace coppice::bake {

/// How much more of a picture a leaf covers than the card that shows it in the quad: the mean over directions of the leaf's outline, by
/// that of its outline in the quad's plane. A leaf that is bent, folded or has volume shows something where a card is seen edge-on. 1: it
/// is flat. Never less than 1. quad  a rectangle that holds the leaf
double fullness(const Plant& plant, const LeafRange& leaf, const Quad& quad);

}  // namespace coppice::bake
