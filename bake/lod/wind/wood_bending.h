#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "wood_skeleton.h"

namespace coppice::bake {

/// What catches the wind at a ring.
struct RingLoad {
  double area_m2 = 0.0;
  glm::dvec3 moment{0.0};  ///< area times place
};

/// How full wind bends the wood at a ring, as a cantilever from its parent: the stem from the ground on, a branch from the stem on.
struct RingBend {
  bool is_stem = false;
  double offset_m = 0.0;              ///< how far it is moved, of a branch against where it leaves the stem
  double slope = 0.0;                 ///< by how much more a metre further on
  std::uint32_t branch_ring = kNone;  ///< of a branch: its first ring off the stem
};

/// A stem or a branch as a whole.
struct Beam {
  double length_m = 0.0, diameter_m = 0.0;  ///< mean of all, by load; 0 where there are none
};

struct WoodBend {
  std::vector<RingBend> rings;  ///< [rings]
  double top_m = 0.0;           ///< how far the stem's bending moves the plant's top, if the stem went on to it; the mean of several stems
  Beam stem, branches;
};

/// Gale and wood: a stiff cantilever's curvature is moment over E I, with I = pi r^4 / 4; the moment of a ring is the wind's force on all
/// that it bears, at its mean distance. Young's modulus of green wood; of plants below kWoodHeight_m, which are herbs and
/// shoots, less, as their height is, down to a tenth. The pressure of 25 m/s, and the drag of crowns that fold up in it (Vollsinger et al.
/// 2005 measured 0.2 to 0.4 at 20 m/s).
inline constexpr double kWoodModulus_pa = 7e9, kGalePressure_pa = 375.0, kCrownDrag = 0.25, kWoodHeight_m = 3.0;

/// loads  [rings.size()] of leaves; what the wood itself catches is added
/// most_area_m2  of all loads: those of crowns that shelter themselves are smaller by one factor
WoodBend bend_wood(std::span<const Ring> rings, std::vector<RingLoad> loads, const Stand& stand, double most_area_m2);

}  // namespace coppice::bake
