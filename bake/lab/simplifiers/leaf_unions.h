#pragma once

// Simplifiers that unite two leaves into one, the cheapest pair first.

#include <cstdint>
#include <vector>

#include "leaf_shade.h"
#include "level.h"
#include "plant.h"

namespace coppice::bake {

/// The length of a rectangle that replaces two leaves.
enum class RectangleLength {
  extent,   ///< as long as both together
  similar,  ///< with the larger leaf's proportions
};

/// Makes a rectangle with the area of both leaves about their common centre of area, in the plane of their mean normal, along the direction
/// of the pair's largest diameter, with stalk and tip as the first's. Without area it is the first leaf.
Quad united_rectangle(const Quad& first, const Quad& second, RectangleLength length);

/// Error of a pair in the Foliage Simplification Algorithm: angle_weight (1 - abs(n1 . n2)) + (1 - angle_weight) distance of centroids /
/// leaf_size_m
double fsa_error(const Quad& first, const Quad& second, double angle_weight, double leaf_size_m);

/// Among the quads of four of the pair's vertices, whose diagonals are their longest distance and the other two's, selects the one whose
/// area and centroid are nearest to the pair's: abs(A - A1 - A2) / (A1 + A2) + length(c - c12) / sqrt(A1 + A2) is minimal.
Quad area_keeping_quad(const Quad& first, const Quad& second);

/// The Foliage Simplification Algorithm (Remolar, Chover, Belmonte, Ribelles, Rebollo: Geometric Simplification of Foliage, Eurographics
/// 2002, short papers). In a leaf collapse two leaves disappear and create one whose vertices are four of theirs and whose area is similar
/// to theirs. The pair with the smallest error goes first; the error weights how near two leaves are and how nearly they lie in one plane.
/// Only the abstract is public, and what later papers say about it. So the weights and the rule for the four vertices are swept: the
/// farthest ones, which the same group's later papers choose, or those that keep the area.
/// leaf_counts  each 1 .. leaf_count (asserted); not empty
std::vector<Variant> simplify_fsa(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts);

/// Cost of a pair in the progressive leaves union: diameter of both / leaf_size_m + angle_weight (1 - abs(n1 . n2)) + abs(A1 - A2) /
/// (A1 + A2)
double leaves_union_cost(const Quad& first, const Quad& second, double angle_weight, double leaf_size_m);

/// Progressive leaves union (Zhang, Blaise: Progressive Polygon Foliage Simplification, PMA 2003): two leaves become one with the area of
/// both. The pair that goes is the one whose union is the smallest, least bent and least unequal. Only abstracts are public, and what later
/// papers of the group say: unions keep area, and diameter, normal and area are weighted. So the weights and the union's proportions are
/// swept.
/// leaf_counts  as for simplify_fsa
std::vector<Variant> unite_leaves(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts);

/// Groups leaves by the tree of their stalks, in order: neighbours are halves of one whole. The number of groups is a power of two.
/// max_size  of a group, at least 1
std::vector<std::vector<std::uint32_t>> stalk_groups(const Foliage& foliage, std::uint32_t max_size);

/// Hierarchical union of organs (Zhang, Blaise, Jaeger: Multiresolution Plant Models with Complex Organs, VRCIA 2006). Leaves are united as
/// by unite_leaves, but along the plant's hierarchy: first those of one phyllotaxy group, then groups of one axis, then axes. A mesh has
/// no record of its growth, and no more of the paper's rules is public. So the hierarchy here is a tree over the stalks: the leaves are
/// halved at the median of their stalks along the longest side of their box until groups are small enough. Within a group the cheapest pair
/// goes first; when each group is one leaf, two neighbouring groups become one. The maximum size of the smallest groups is swept.
/// leaf_counts  as for simplify_fsa
std::vector<Variant> unite_organs(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
