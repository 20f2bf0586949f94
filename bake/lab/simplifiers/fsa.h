#pragma once

// The Foliage Simplification Algorithm (Remolar, Chover, Belmonte, Ribelles, Rebollo: Geometric Simplification of Foliage, Eurographics
// 2002, short papers). In a leaf collapse two leaves disappear and create one whose vertices are four of theirs and whose area is similar
// to theirs. The pair with the smallest error goes first; the error weights how near two leaves are and how nearly they lie in one plane.
// Only the abstract is public, and what later papers say about it. So the weights and the rule for the four vertices are swept: the
// farthest ones, which the same group's later papers choose, or those that keep the area.

#include <vector>

#include "level.h"
#include "plant.h"

namespace coppice::bake {

/// Error of a pair: angle_weight (1 -
/// n1 . n2
/// ) + (1 - angle_weight) distance of centroids / leaf_size_m
double fsa_error(const Quad& first, const Quad& second, double angle_weight, double leaf_size_m);

/// Among the quads of four of the pair's vertices, whose diagonals are their longest distance and the other two's, selects the one whose
/// area and centroid are nearest to the pair's:
/// A - A1 - A2
///  / (A1 + A2) +
/// c - c12
///  / sqrt(A1 + A2) is minimal.
Quad area_keeping_quad(const Quad& first, const Quad& second);

/// leaf_counts  each 1 .. leaf_count (asserted); not empty
std::vector<Variant> simplify_fsa(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
