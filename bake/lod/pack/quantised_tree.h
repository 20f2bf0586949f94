#pragma once

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// The box whose steps are the file's coordinates.
struct QuantisationBox {
  glm::vec3 min{0.0f}, max{0.0f};
  std::uint32_t steps = COPPICE_QUANTISED_MAX;  ///< along each axis
};

/// The box of all leaf vertices.
QuantisationBox leaf_box(const Tree& tree, std::uint32_t steps);

/// The nearest step. Its error is at most half of (max - min) / steps, plus rounding of floats.
QuantisedPoint quantise(const QuantisationBox& box, const glm::vec3& point);

/// The point that a reader of the file computes.
glm::vec3 dequantise(const QuantisationBox& box, const QuantisedPoint& point);

/// A tree as the file stores it.
struct QuantisedTree {
  QuantisationBox box;
  std::vector<PageNode> nodes;  ///< [2N - 1]
  std::vector<Split> splits;    ///< [N - 1]
};

/// errors  invalid_argument: a parent's vertices are not four of its children's, arrays disagree, a split's parent is not alive, a
///         vertex is not finite, a node has an opacity or normals that the file cannot hold
Result<QuantisedTree> quantise_tree(const Tree& tree, std::uint32_t steps = COPPICE_QUANTISED_MAX);

}  // namespace coppice::bake
