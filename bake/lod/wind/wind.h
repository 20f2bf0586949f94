#pragma once

#include <span>

#include "plant.h"

namespace coppice::bake {

struct WindOptions {
  bool moves = true;       ///< false: wind does not move the plant
  float stiffness = 1.0f;  ///< 2 moves half as far; kMinWindStiffness to kMaxWindStiffness
};

inline constexpr float kMinWindStiffness = 0.1f, kMaxWindStiffness = 10.0f;

/// A plant as wind sees it.
struct WindSource {
  const Mesh& wood;
  const Mesh& foliage;                ///< the leaves as they were modelled
  std::span<const LeafRange> leaves;  ///< of the foliage
  std::span<const Quad> quads;        ///< at least [leaves.size()] their quads
  Sphere sphere;                      ///< bounds all of these
};

/// How wind moves a plant, told from its wood, or without wood from where its leaves are, and from wind weights where the source has them.
/// Within the limits of format.h for any plant. Does not depend on the number of threads.
///
/// - *Bend*: the stem as a cantilever under a gale, wood_bending.h, at the plant's top.
/// - *Lean*: the same of branches and twigs, from where they leave the stem; of a place the square root of its deflection over that of the
///   leaves that move most, so that it grows evenly along a branch. A weight says it outright.
/// - *Sway*: as large as the lean, in one of sixteen phases a branch, a quarter turn before or after the mean at most.
/// - *Limits*: they are a fraction of what slender plants do in a gale. 30 % of the bend counts and 40 % of the lean, so that stout plants
///   differ from slender ones; what would be over a limit all the same comes near to it. Beside a grid, bend takes at most two fifths of
///   them.
/// - *Periods*: 1 / (0.0766 + 3.1219 d / h^2) s, with d in cm and h in m, of trees (Moore and Maguire 2004); a branch, heavy with leaves,
///   half as fast as a tree of its length and thickness. Between 0.25 s and 10 s.
Wind wind_of(const WindSource& source, const WindOptions& options);

/// Nodes a side of the grid of so many leaves: at most two bytes a leaf.
std::uint32_t wind_node_side(std::size_t leaf_count);

}  // namespace coppice::bake
