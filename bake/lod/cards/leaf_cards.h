#pragma once

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Maximum number of card images of a material: they share one atlas of at most 4 x 4.
inline constexpr std::uint32_t kMaxCardImages = 16;

/// A leaf as its quad shows it: linear RGB times alpha, and alpha; rows top to bottom. The left edge is the quad's stalk edge (corners 3,
/// 0), the top edge runs from corner 3 to 2. Colours are relative to the base colour of the leaf's material.
struct CardImage {
  std::uint32_t side_px = 0;
  std::vector<glm::vec4> texels;  ///< [side_px * side_px]
};

/// Draws the leaf's triangles along the normal of its (rectangular) quad, front up. A texel is the mean of samples * samples points, each
/// with the topmost texel that is no hole.
CardImage draw_leaf(const Plant& plant, const LeafRange& leaf, const Quad& quad, std::uint32_t side_px, std::uint32_t samples);

/// Ratio of the area that a leaf covers on screen to that of its card: the mean area of the leaf's outline over directions, divided by the
/// area of its outline in the quad's plane. A leaf that is bent, folded or has volume shows something even where a card is seen edge-on. At
/// least 1; 1 for a flat leaf.
/// quad  a rectangle that holds the leaf
double fullness(const Plant& plant, const LeafRange& leaf, const Quad& quad);

/// Makes the plant's leaves quads that look like them: fits quads (fit_leaves), then gives each leaf that is not a quad itself a card that
/// shows it, so that the quad has the leaf's outline, colours and area, and shares cards (share_leaf_cards). The quad is refitted along its
/// sides, to hold exactly what the leaf shows. In each material, leaves are clustered by small images of them: as many clusters as it takes
/// for every leaf to be like its image, at most kMaxCardImages. One leaf of each cluster is drawn into an atlas, as large as its own
/// texture shows it (64 to 256 px). The atlas is a new material and image of the plant, alpha masked. At last it gives leaves their normals
/// (leaf_normals.h). The result does not depend on the number of threads. errors  those of fit_leaves
Result<Foliage> card_foliage(Plant& plant);

}  // namespace coppice::bake
