#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "leaf_fit.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Pictures per material: they share one atlas of at most 4 x 4.
inline constexpr std::uint32_t kMaxPictures = 16;

/// A leaf as its quad shows it: linear RGB times alpha, and alpha; rows top to bottom. The left edge is the quad's stalk edge (corners 3,
/// 0), the top one runs from corner 3 to 2. `color` is relative to the base colour of the leaf's material.
struct LeafPicture {
  std::uint32_t side_px = 0;
  std::vector<glm::vec4> texels;  ///< [side_px * side_px]
};

/// Looks at the leaf's triangles along the normal of its (rectangular) quad, front up: the topmost texel that is no hole, of
/// samples * samples points a texel.
LeafPicture draw_leaf(const Plant& plant, const LeafRange& leaf, const Quad& quad, std::uint32_t side_px, std::uint32_t samples);

/// Gives each leaf that is not a quad itself a card that looks like it, so that the quad has the leaf's outline, colours and area; the
/// quad is fitted anew along its sides, to hold all that the leaf shows and no more. Per
/// material, leaves are clustered by small pictures of them (as many clusters as it takes for every leaf to be like its picture, at most
/// kMaxPictures); one leaf of each is drawn, as large as its own texture shows it (64 to 256 px), into an atlas, which is a new material
/// and image of the plant, alpha masked. fitted  [plant.leaves.size()] what fit_leaves returned; quads and cards are replaced Does not
/// depend on the number of threads.
void draw_leaf_cards(Plant& plant, std::span<FittedLeaf> fitted);

/// The plant's leaves as quads that look like them: fit_leaves, draw_leaf_cards, share_leaf_cards.
/// errors  those of fit_leaves
Result<Foliage> card_foliage(Plant& plant);

}  // namespace coppice::bake
