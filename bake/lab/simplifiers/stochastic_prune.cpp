#include "stochastic_prune.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "check.h"
#include "leaf_scale.h"
#include "seeded_random.h"

namespace coppice::bake {

std::vector<std::uint32_t> stochastic_order(std::uint32_t leaf_count, std::uint64_t seed) {
  std::vector<std::uint32_t> order(leaf_count);
  std::iota(order.begin(), order.end(), 0u);
  SeededRandom random(seed);
  for (std::uint32_t i = leaf_count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

Foliage prune_stochastically(const Foliage& foliage, std::uint32_t kept_count, std::uint64_t seed) {
  COPPICE_ASSERT(kept_count >= 1 && kept_count <= foliage.leaf_count());
  std::vector<std::uint32_t> kept = stochastic_order(foliage.leaf_count(), seed);
  kept.resize(kept_count);
  std::sort(kept.begin(), kept.end());
  const double factor = std::sqrt(static_cast<double>(foliage.leaf_count()) / kept_count);
  Foliage result;
  result.card_table = foliage.card_table;
  for (const std::uint32_t leaf : kept) {
    result.quads.push_back(factor == 1.0 ? foliage.quads[leaf] : scaled_quad(foliage.quads[leaf], factor));
    result.cards.push_back(foliage.cards[leaf]);
  }
  return result;
}

}  // namespace coppice::bake
