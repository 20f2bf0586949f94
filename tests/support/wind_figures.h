#pragma once

// What wind does to a plant: how far it bends, and what would look wrong: leaves that come off their twigs, a crown that breathes.

#include <array>
#include <cstdint>

#include "plant.h"

namespace coppice::test {

/// Over many moments and directions of a wind of 25 m/s. Gaps: of each leaf between its stalk and the nearest place of the wood at rest, by
/// how much more or less it is in the wind, as a share of the leaf's length, or of the gap at rest where the leaf floats farther away.
struct WindFigures {
  double radius_m = 0.0;
  double bend_share = 0.0;                               ///< how far the stem's bending moves the top, relative to the height
  double reach_m = 0.0;                                  ///< by the file's field nothing is moved further
  double growth = 0.0;                                   ///< the field's max_wind_growth
  double move_median_m = 0.0;                            ///< how far the median leaf is off its place, at most
  double move_max_m = 0.0;                               ///< how far the leaf that moves most is
  double gap_median = 0.0, gap_99 = 0.0, gap_max = 0.0;  ///< each leaf's largest; 0 without leaves or wood
  double volume_max = 0.0;                               ///< largest change of the crown's volume (covariance of leaves), as a share
  double squeeze_max = 0.0;                              ///< largest change of the volume about a leaf: of the field's Jacobian
  /// How far winds of kTipWinds_mps move the highest place at most, without gusts, as a share of the plant's height.
  std::array<double, 3> tip_shares{};
  double stretch_max =
      0.0;  ///< largest change of the length of an edge of wood or leaves as modelled, as a share, in the last of these winds
};

inline constexpr std::array<float, 3> kTipWinds_mps{3.0f, 8.0f, 15.0f};

/// plant: with its leaves as modelled; leaf quads are made of them here. Of many leaves so many are looked at, evenly.
/// Throws std::runtime_error where no quads can be made of them.
WindFigures wind_figures(bake::Plant plant, std::uint32_t max_leaves = 1500);

}  // namespace coppice::test
