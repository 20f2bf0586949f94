#pragma once

#include "plant.h"

namespace coppice::bake {

struct WindOptions {
  bool moves = true;       ///< false: wind does not move the plant
  float stiffness = 1.0f;  ///< 2 moves half as far; kMinWindStiffness to kMaxWindStiffness
};

inline constexpr float kMinWindStiffness = 0.1f, kMaxWindStiffness = 10.0f;

/// A plant for the computation of its wind.
struct WindSource {
  const Mesh& wood;
  const Mesh& foliage;                ///< the leaves as they were modelled
  std::span<const LeafRange> leaves;  ///< ranges of `foliage`
  std::span<const Quad> quads;        ///< at least [leaves.size()] the leaves' quads
  Sphere sphere;                      ///< bounds all of these
};

/// Computes how wind moves a plant: from its wood, or without wood from where its leaves are, and from wind weights if the source has them.
/// The result is within the limits of format.h for any plant, and does not depend on the number of threads.
///
/// - *Bend*: the stem as a cantilever under a gale (wood_bending.h), at the plant's top.
/// - *Lean*: the same for branches and twigs, from where they leave the stem. A place's lean is the square root of its deflection relative
/// to that of the leaves that move most, so that it grows evenly along a branch. A wind weight replaces it.
/// - *Sway*: as large as the lean, in one of sixteen phases a branch, at most a quarter turn before or after the mean.
/// - *Limits*: the bend is as the square root of what is computed, and approaches its limit from below: 32 % of the height up to 2.5 m, 6 %
/// from 6 m on, 60 % of the radius at most. So 15 m/s moves the tops of slender trees by 2 to 5 % of their height, and those of crops and
/// grasses by 10 to 40 %, as observed. 40 % of the lean counts; with the sway it approaches 6 % of the radius.
/// - *Periods*: 1 / (0.0766 + 3.1219 d / h^2) s, with d in cm and h in m, measured on trees (Moore and Maguire 2004); a branch, heavy with
/// leaves, is half as fast as a tree of its length and thickness. A stem that bends far is not faster than a pendulum about as long as its
/// bend. Between 0.25 s and 10 s.
Wind wind_of(const WindSource& source, const WindOptions& options);

/// Nodes on each side of the grid for so many leaves: at most two bytes a leaf.
std::uint32_t wind_node_side(std::size_t leaf_count);

}  // namespace coppice::bake
