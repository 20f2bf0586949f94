#pragma once

// How well one quad replaces two leaves, seen alone: compares silhouettes of the pair and of every quad that its eight vertices make, as
// small bit images from a few directions. A cheap first look; incremental_image.h then judges the best few in the crown.

#include <algorithm>
#include <cmath>

#include "plant.h"
#include "quad_merge.h"

namespace coppice::bake {

/// A quad for a pair, and areas of both when nothing hides them: means over directions.
struct PairShape {
  PairCorners corners{};
  float pair_m2 = 0.0f, quad_m2 = 0.0f;  ///< silhouettes of each
  float shared_m2 = 0.0f;                ///< silhouette of what both cover

  /// Mismatch between the quad and the pair: their squared difference of opacity, plus the difference of their covered areas. For opaque
  /// leaves and an opaque quad: the silhouettes' symmetric difference + difference of their areas.
  [[nodiscard]] float mismatch_m2(float pair_opacity, float opacity) const {
    const float squares = pair_opacity * pair_opacity * pair_m2 - 2.0f * pair_opacity * opacity * shared_m2 + opacity * opacity * quad_m2;
    return std::max(squares, 0.0f) + pair_opacity * std::abs(opacity * quad_m2 - pair_opacity * pair_m2);
  }
  /// The opacity with which the quad covers as much as the pair; at most the pair's.
  [[nodiscard]] float covering_opacity(float pair_opacity) const {
    return quad_m2 > pair_m2 ? pair_opacity * pair_m2 / quad_m2 : pair_opacity;
  }
};

/// The quads that a pair's merged leaf may have, at most kMax, all different.
struct PairShapes {
  static constexpr std::size_t kOpaque = 2, kTranslucent = 2, kMax = kOpaque + kTranslucent + 1;
  std::array<PairShape, kMax> shapes{};
  std::size_t count = 0;
  [[nodiscard]] std::span<const PairShape> all() const& { return std::span(shapes).first(count); }
  void all() && = delete;  // the span of a temporary, which a range-based for does not keep, would dangle
};

/// Selects from all 420 quads (70 sets of four vertices, three rings, two diagonals): first the kOpaque with the smallest mismatch as
/// opaque quads, in order; then the kTranslucent with the smallest mismatch at the opacity that covers as much as the pair; then the
/// paper's merge_corners, the one quad that can grow most. Each silhouette is 16 x 16 cells over the pair's bounding rectangle, seen from
/// the six axes of an icosahedron. Ties go to the quad that is first in lexicographic order of sorted vertices, ring, diagonal. Corner 0
/// and winding put each corner nearest to the same corner of the larger leaf (the first of equals), whose card is shown.
PairShapes pair_shapes(const Quad& first, const Quad& second);

}  // namespace coppice::bake
