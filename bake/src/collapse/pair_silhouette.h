#pragma once

// How well one quad stands in for two leaves, seen alone: silhouettes of the pair and of every quad that its eight vertices make, as small
// bit images from a few directions. A cheap first look; live_image.h then judges the best few in the crown.

#include <array>
#include <cstdint>
#include <span>

#include "plant.h"

namespace coppice::bake {

/// Four of a pair's eight vertices (0..3 of first, 4..7 of second) in ring order: the corners of a quad.
using PairCorners = std::array<std::uint8_t, 4>;

/// A quad for a pair, and how unlike the pair it is when nothing hides either.
struct PairShape {
  PairCorners corners{};
  float mismatch_m2 = 0.0f;  ///< mean over directions of |silhouettes' symmetric difference| + |difference of their areas|
};

/// Of all 420 quads (70 sets of four vertices, three rings, two diagonals) those of least mismatch, the least first; then, last, the
/// paper's merge_corners, the one quad that can grow. Each silhouette is 16 x 16 cells over the pair's bounding rectangle, seen from the
/// six axes of an icosahedron; ties go to the quad that is first in lexicographic order of sorted vertices, ring, diagonal. Corner 0 and
/// winding are those that put each corner nearest to the same corner of the larger leaf (the first of equals), whose card is shown.
/// shapes  filled; at least 1
void pair_shapes(const Quad& first, const Quad& second, std::span<PairShape> shapes);

}  // namespace coppice::bake
