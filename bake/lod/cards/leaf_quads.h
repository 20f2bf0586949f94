#pragma once

#include <vector>

#include "leaf_fit.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Fits one quad to each leaf of the plant: the paper's section III, equation (1). The leafstalk point is the leaf vertex nearest the wood
/// (branch_distance.h), the tip the leaf vertex farthest from where the wood bears it; of vertices that are equally far, or if that is the
/// stalk, the farthest from the stalk. The plane through the stalk and two other vertices that minimises the summed distance of all
/// vertices (leaf_fit.h); in it the rectangle along stalk-tip that is as wide on either side as the leaf. Its front looks where the leaf's
/// does. A leaf that is a quad already (two triangles, four vertices) keeps its corners and winding, turned so that the edge from corner 3
/// to 0 is the nearest to the wood. result  one quad per leaf, in leaf order, with the part of the leaf's texture that lies on it. Does not
/// depend on the number of threads.
/// errors  invalid_argument: a leaf without area
Result<std::vector<FittedLeaf>> fit_leaves(const Plant& plant);

/// Leaves with few cards: the distinct (material, corner uv) of the leaves, at most COPPICE_MAX_CARDS (card_table.h).
Foliage share_leaf_cards(const std::vector<FittedLeaf>& leaves, const std::vector<Material>& materials);

/// fit_leaves and share_leaf_cards: quads that show the leaf's texture, without its outline. See leaf_cards.h for those that have it.
Result<Foliage> fit_leaf_quads(const Plant& plant);

}  // namespace coppice::bake
