#pragma once

#include <vector>

#include "leaf_fit.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Fits one quad to each leaf of the plant: the paper's section III, equation (1). The stalk is the leaf vertex nearest the wood
/// (branch_distance.h), the tip the leaf vertex farthest from where the wood bears it; if several are equally far, or the farthest is the
/// stalk, the one farthest from the stalk. The plane goes through the stalk and two other vertices and minimises the summed distance of all
/// vertices (leaf_fit.h). The quad is the rectangle in it along stalk and tip, as wide on either side as the leaf; its front faces as the
/// leaf's does. A leaf that is a quad already (two triangles, four vertices) keeps its corners and winding, turned so that the edge from
/// corner 3 to 0 is nearest to the wood.
/// returns  one quad per leaf, in leaf order, with the part of the leaf's texture that lies on it; does not depend on the number of threads
/// errors  invalid_argument: a leaf without area
Result<std::vector<FittedLeaf>> fit_leaves(const Plant& plant);

/// Shares cards between leaves: the distinct (material, corner uv), at most COPPICE_MAX_CARDS (card_table.h).
Foliage share_leaf_cards(const std::vector<FittedLeaf>& leaves, const std::vector<Material>& materials);

/// fit_leaves and share_leaf_cards: quads that show the leaf's texture, but not its outline. card_foliage (leaf_cards.h) shows the outline
/// too.
Result<Foliage> fit_leaf_quads(const Plant& plant);

}  // namespace coppice::bake
