#pragma once

#include <array>
#include <cstdint>

#include "plant.h"

namespace coppice::bake {

/// Four of a pair's eight vertices (0..3 of first, 4..7 of second), in ring order: the quad that is most like the two leaves together.
///
/// Of all 210 rings it has the least  (a - A)^2 + |n - N|^2 + A |c - C|^2:  a its area, n its area vector (half the cross product of its
/// diagonals: short for a folded or crossed quad), c its centroid; A the two leaves' area, N the sum of their area vectors turned to the
/// same side, C the centroid of both by area. Ties: the first ring, in lexicographic order of its sorted vertices. Its corner 0 and
/// winding are those that put each corner nearest to the same corner of the larger leaf (the first of equals), whose card it shows.
std::array<std::uint8_t, 4> matching_corners(const Quad& first, const Quad& second);

}  // namespace coppice::bake
