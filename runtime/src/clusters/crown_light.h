#pragma once

// How much of the sun and of the sky reaches a place inside a crown, from the leaves of a coarse cut. A crown is taken for a medium: a cell
// of the leaf box dims light by the area of its leaves. From each cell's middle light is followed outwards along fourteen directions, and
// what is kept of them is little: optical depth as a linear function of direction, and one share of the sky. Both ways of drawing read
// the same grid (crown_light_at in shading.glsl), so that a plant does not change its light with its level of detail.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "coppice_shared.h"
#include "tree.h"

namespace coppice::gpu {

/// What leaf corners are quantised in: min + step * q, q <= largest. Object space, m.
struct LeafBox {
  vec3 min{}, step{};
  std::uint32_t largest = 1;
};

/// At a place. Optical depth towards unit direction d: depth + dot(slope, d), not below 0.
struct CrownSample {
  float depth = 0;
  std::array<float, 3> slope{};
  float sky = 1;  ///< share of the light of the sky that arrives, 0..1
};

/// CrownSample at the middle of each cell of the leaf box: x fastest, then y. Empty: nothing is dimmed.
struct CrownLight {
  LeafBox box;
  std::vector<CrownSample> cells;  ///< [kCrownCells^3] or none

  /// Between cells linearly, outside the box what its nearest place has. place: object space, m
  [[nodiscard]] CrownSample at(const std::array<float, 3>& place) const;
};

/// The leaves of a cut, whose quads may have holes.
struct CrownSource {
  PageNode root;
  std::span<const PageNode> nodes;  ///< node 1 and on: [2 m - 2] of a cut of m leaves
  std::span<const CardLook> looks;  ///< of the cards
  LeafBox box;
};
CrownLight measure_crown(const CrownSource& source);

/// As shaders read it: unpack_crown of shading.glsl.
std::uint32_t pack_crown(const CrownSample& sample);
/// [kCrownCells^3]
std::vector<std::uint32_t> pack_crown(const CrownLight& light);

}  // namespace coppice::gpu
