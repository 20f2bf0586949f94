#pragma once

// Progressive leaves union (Zhang, Blaise: Progressive Polygon Foliage Simplification, PMA 2003): two leaves become one that has the area
// of both. The pair that goes is the one whose union is least large, least bent and least unequal. Public are abstracts and what later
// papers of the group tell: that unions keep area, and that diameter, normal and area are weighed. The weights and the union's proportions
// are therefore swept.

#include <vector>

#include "level.h"
#include "plant.h"

namespace coppice::bake {

/// diameter of both / leaf_size_m + angle_weight (1 - |n1 . n2|) + |A1 - A2| / (A1 + A2)
double leaves_union_cost(const Quad& first, const Quad& second, double angle_weight, double leaf_size_m);

/// leaf_counts  each 1 .. leaf_count (asserted); not empty
std::vector<Variant> unite_leaves(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
