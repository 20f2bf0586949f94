#pragma once

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Fits one quad to each leaf of the plant: the paper's section III, equation (1). The leafstalk point is the leaf vertex nearest the wood,
/// the tip the leaf vertex farthest from it; the plane through the stalk and two other vertices that minimises the summed distance of all
/// vertices; the rectangle along stalk-tip in that plane. A leaf that is a quad already (two triangles, four vertices) is kept as it is.
/// result  one quad per leaf, in leaf order; cards are the distinct (material, corner uv) of the leaves, at most COPPICE_MAX_CARDS.
Result<Foliage> fit_leaf_quads(const Plant& plant);

}  // namespace coppice::bake
