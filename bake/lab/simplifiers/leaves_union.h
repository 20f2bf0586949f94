#pragma once

// Progressive leaves union (Zhang, Blaise: Progressive Polygon Foliage Simplification, PMA 2003): two leaves become one with the area of
// both. The pair that goes is the one whose union is the smallest, least bent and least unequal. Only abstracts are public, and what later
// papers of the group say: unions keep area, and diameter, normal and area are weighted. So the weights and the union's proportions are
// swept.

#include <vector>

#include "level.h"
#include "plant.h"

namespace coppice::bake {

/// Cost of a pair: diameter of both / leaf_size_m + angle_weight (1 -
/// n1 . n2
/// ) +
/// A1 - A2
///  / (A1 + A2)
double leaves_union_cost(const Quad& first, const Quad& second, double angle_weight, double leaf_size_m);

/// leaf_counts  each 1 .. leaf_count (asserted); not empty
std::vector<Variant> unite_leaves(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
