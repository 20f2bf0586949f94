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

/// How full wind bends the wood at a ring, as a cantilever: the stem from the ground on, a branch from the stem on.
struct RingBend {
  bool is_stem = false;
  double offset_m = 0.0;              ///< how far the ring moves; for a branch, relative to where it leaves the stem
  double slope = 0.0;                 ///< how much the offset grows for each metre further on
  std::uint32_t branch_ring = kNone;  ///< a branch's first ring off the stem
};

/// Mean dimensions of all stems or of all branches.
struct Beam {
  double length_m = 0.0, diameter_m = 0.0;  ///< weighted by load; 0 if there are none
};

struct WoodBend {
  std::vector<RingBend> rings;  ///< [rings]
  double top_m = 0.0;           ///< how far bending moves the plant's top, as if the stem went on to it; the mean of several stems
  Beam stem, branches;
};

/// Constants of gale and wood. A stiff cantilever's curvature is moment / (E I), with I = pi r^4 / 4; the moment at a ring is the wind's
/// force on all that the ring bears, at its mean distance. E is Young's modulus of green wood; plants below kWoodHeight_m are herbs and
/// shoots and have less, in proportion to their height, down to a tenth. The pressure is that of 25 m/s, the drag that of crowns that fold
/// up in it (Vollsinger et al. 2005 measured 0.2 to 0.4 at 20 m/s).
inline constexpr double kWoodModulus_pa = 7e9, kGalePressure_pa = 375.0, kCrownDrag = 0.25, kWoodHeight_m = 3.0;

/// loads        [rings.size()] the leaves' loads; the wood's own are added
/// max_area_m2  limit for all loads: crowns that shelter themselves are scaled down to it
WoodBend bend_wood(std::span<const Ring> rings, std::vector<RingLoad> loads, const Stand& stand, double max_area_m2);

}  // namespace coppice::bake
