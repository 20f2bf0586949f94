#pragma once

// A leaf that stands for two: what the methods that unite leaves share.

#include <cstdint>
#include <vector>

#include "greedy_union.h"
#include "level.h"
#include "plant.h"

namespace coppice::bake {

struct UnitedLeaf {
  Quad quad{};
  std::uint32_t card = 0;
};

std::vector<UnitedLeaf> united_leaves(const Foliage& foliage);
Level level_of(const std::vector<UnitedLeaf>& leaves, const std::vector<Card>& card_table);

/// Unit, or zero for a quad without area; of a bent quad the mean.
glm::dvec3 quad_normal(const Quad& quad);

/// 1 - |n1 . n2|: 0 for parallel leaves, 1 for leaves at right angles, or without area.
double leaf_angle(const Quad& first, const Quad& second);

/// The longest distance between two of the eight corners, m.
double pair_diameter_m(const Quad& first, const Quad& second);

/// How long a rectangle that stands for two leaves is made.
enum class RectangleLength {
  extent,   ///< as long as both together
  similar,  ///< of the larger leaf's proportions
};

/// A rectangle of the area of both about their common centre of area, in the plane of their mean normal, along the direction of the pair's
/// largest diameter, stalk and tip as the first's. Without area: the first. m
Quad united_rectangle(const Quad& first, const Quad& second, RectangleLength length);

}  // namespace coppice::bake
