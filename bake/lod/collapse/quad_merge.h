#pragma once

#include "plant.h"

namespace coppice::bake {

/// Area of the quad's two triangles, m^2.
double quad_area(const Quad& quad);

/// Mean of the four corners.
glm::dvec3 quad_centroid(const Quad& quad);

/// Four of a pair's eight vertices (0..3 of first, 4..7 of second) in ring order: the corners of a quad.
using PairCorners = std::array<std::uint8_t, 4>;
using PairVertices = std::array<glm::dvec3, 8>;
PairVertices pair_vertices(const Quad& first, const Quad& second);

/// The paper's Fig. 3. Among the pair's eight vertices (0..3 of first, 4..7 of second) v1 and v2 are the two farthest apart; v3, then v4,
/// is the remaining one with the largest summed distance to those already chosen. Ties go to the smaller vertex, for v1 before v2.
/// returns  v1, v3, v2, v4: the corners of the new quad in ring order
PairCorners merge_corners(const Quad& first, const Quad& second);

/// The quad that merge_corners names.
Quad merged_quad(const Quad& first, const Quad& second, const PairCorners& corners);

/// The card of the larger leaf; the first one's if they are equal.
std::uint32_t merged_card(const Quad& first, std::uint32_t first_card, const Quad& second, std::uint32_t second_card);

}  // namespace coppice::bake
