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

Result<Foliage> fit_leaf_quads(const Plant& plant) {
  for (std::size_t i = 0; i < plant.leaves.size(); ++i)
    if (!has_area(plant.foliage, plant.leaves[i]))
      return Error{Status::invalid_argument, "leaf without area", Error::kNoOffset, "leaf " + std::to_string(i)};
  const BranchDistance branch(plant);
  Foliage foliage;
  foliage.quads.resize(plant.leaves.size());
  std::vector<Card> cards(plant.leaves.size());
  // Each leaf writes its own slot: the result does not depend on who fits which.
  constexpr std::size_t kGrain = 64;
  parallel_for(
      plant.leaves.size(),
      [&](std::size_t i) {
        const FittedLeaf fitted = fit_leaf(plant, plant.leaves[i], branch);
        foliage.quads[i] = fitted.quad;
        cards[i] = fitted.card;
      },
      kGrain);
  SharedCards shared = share_cards(cards, plant.materials);
  foliage.card_table = std::move(shared.table);
  foliage.cards = std::move(shared.card_of);
  return foliage;
}

}  // namespace coppice::bake
