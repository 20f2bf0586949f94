#pragma once

// A leaf that replaces two, shared by the methods that unite leaves.

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

/// Unit normal, the mean for a bent quad; zero for a quad without area.
glm::dvec3 quad_normal(const Quad& quad);

/// 1 - |n1 . n2|: 0 for parallel leaves, 1 for leaves at right angles, or without area.
double leaf_angle(const Quad& first, const Quad& second);

/// The longest distance between two of the eight corners, m.
double pair_diameter_m(const Quad& first, const Quad& second);

/// The length of a rectangle that replaces two leaves.
enum class RectangleLength {
  extent,   ///< as long as both together
  similar,  ///< with the larger leaf's proportions
};

/// Makes a rectangle with the area of both leaves about their common centre of area, in the plane of their mean normal, along the direction
/// of the pair's largest diameter, with stalk and tip as the first's. Without area it is the first leaf.
Quad united_rectangle(const Quad& first, const Quad& second, RectangleLength length);

}  // namespace coppice::bake
