#include "leaf_quads.h"

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "branch_distance.h"
#include "card_table.h"
#include "leaf_fit.h"
#include "parallel_for.h"

namespace coppice::bake {
namespace {

bool has_area(const Mesh& mesh, const LeafRange& leaf) {
  for (std::size_t t = leaf.first_triangle; t < std::size_t{leaf.first_triangle} + leaf.triangle_count; ++t) {
    const glm::dvec3 a(mesh.positions[mesh.indices[3 * t]]), b(mesh.positions[mesh.indices[3 * t + 1]]),
        c(mesh.positions[mesh.indices[3 * t + 2]]);
    if (glm::length(glm::cross(b - a, c - a)) > 0.0) return true;
  }
  return false;
}

}  // namespace

Result<std::vector<FittedLeaf>> fit_leaves(const Plant& plant) {
  for (std::size_t i = 0; i < plant.leaves.size(); ++i)
    if (!has_area(plant.foliage, plant.leaves[i]))
      return Error{Status::invalid_argument, "leaf without area", Error::kNoOffset, "leaf " + std::to_string(i)};
  const BranchDistance branch(plant);
  std::vector<FittedLeaf> leaves(plant.leaves.size());
  // Each leaf writes its own slot, so the result does not depend on the threads.
  constexpr std::size_t kGrain = 64;
  parallel_for(
      plant.leaves.size(), [&](std::size_t i) { leaves[i] = fit_leaf(plant, plant.leaves[i], branch); }, kGrain);
  return leaves;
}

Foliage share_leaf_cards(const std::vector<FittedLeaf>& leaves, const std::vector<Material>& materials) {
  Foliage foliage;
  std::vector<Card> cards;
  for (const FittedLeaf& leaf : leaves) {
    foliage.quads.push_back(leaf.quad);
    cards.push_back(leaf.card);
  }
  SharedCards shared = share_cards(cards, materials);
  foliage.card_table = std::move(shared.table);
  foliage.cards = std::move(shared.card_of);
  return foliage;
}

Result<Foliage> fit_leaf_quads(const Plant& plant) {
  COPPICE_TRY(leaves, fit_leaves(plant));
  return share_leaf_cards(leaves, plant.materials);
}

}  // namespace coppice::bake
