#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "branch_distance.h"
#include "plant.h"

namespace coppice::bake {

struct FittedLeaf {
  Quad quad{};
  Card card{};  ///< uv as fitted: neither shifted nor shared
};

/// Fits a quad to one leaf of the plant, as fit_leaves does. The leaf has at least three distinct points.
FittedLeaf fit_leaf(const Plant& plant, const LeafRange& leaf, const BranchDistance& branch);

/// A plane by a point and a unit normal.
struct Plane {
  glm::dvec3 point{0.0};
  glm::dvec3 normal{0.0};
};

/// Equation (1) of the paper: the plane through points[stalk] and two others with the smallest summed distance to all points. Nearly
/// collinear triples are no planes. With more than 24 other points the pairs come from 24 of them, each the farthest from the earlier ones,
/// starting with the farthest from the stalk. The first pair wins a tie. The normal is zero if all points lie on one line.
Plane best_plane(std::span<const glm::dvec3> points, std::size_t stalk);

}  // namespace coppice::bake
