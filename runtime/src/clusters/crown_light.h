#pragma once

// Computes how much of the sun and of the sky reaches a place inside a crown, from the leaves of a coarse cut. The crown is treated as a
// medium: each cell of the leaf box dims light by the area of its leaves. From each cell's middle light is traced outwards along fourteen
// directions. The result is small: optical depth as a linear function of direction, and one share of the sky. Both ways of drawing read the
// same grid (crown_light_at of coppice_light.h), so a plant's light does not change with its level of detail.

#include <array>
#include <span>

#include "coppice_light.h"
#include "tree.h"

namespace coppice::gpu {

/// The box that corners are quantised in: min + step * q, q <= largest. Object space, m.
struct LeafBox {
  vec3 min{}, step{};
  std::uint32_t largest = 1;

  [[nodiscard]] vec3 at(const uvec3& q) const { return min + step * vec3(q); }
  /// The step that positions of splats are quantised in.
  [[nodiscard]] vec3 splat_step() const { return step * (static_cast<float>(largest) / 65535.0f); }
};

inline Crown crown_of(const LeafBox& box) {
  return crown_of(box.min, box.step, box.largest);
}

/// pack_crown of the light at the middle of each cell of the leaf box: x fastest, then y. Cells that were not measured dim nothing.
struct CrownLight {
  LeafBox box;
  std::array<std::uint32_t, kCrownCells * kCrownCells * kCrownCells> words;

  CrownLight() { words.fill(pack_crown({.depth = 0.0f, .slope{}, .sky = 1.0f})); }
  [[nodiscard]] CrownSample at(const vec3& place) const { return crown_light_at(words.data(), crown_of(box), place); }
};

/// The leaves of a cut, whose quads may have holes.
struct CrownSource {
  PageNode root;
  std::span<const PageNode> nodes;  ///< from node 1 on: [2 m - 2] for a cut of m leaves
  std::span<const CardLook> looks;  ///< those of the cards
  LeafBox box;
};
CrownLight measure_crown(const CrownSource& source);

}  // namespace coppice::gpu
