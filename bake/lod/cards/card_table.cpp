#include "card_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "coppice/format.h"

namespace coppice::bake {
namespace {

constexpr float kUvSteps = 4096.0f;
// Beyond this a float no longer holds steps of 1/4096, so such coordinates carry no information.
constexpr float kMaxUv = 2048.0f;
// Distance of cards of different materials.
constexpr double kFar = std::numeric_limits<double>::max();

constexpr std::array<glm::vec2, 4> kUnitSquare{{{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}}};

Card canonical(const Card& card, const std::vector<Material>& materials) {
  Card shared{card.material, kUnitSquare};
  if (materials[card.material].image == kNone) return shared;
  glm::vec2 mean(0.0f);
  for (const glm::vec2& uv : card.uv) mean += 0.25f * glm::clamp(uv, -kMaxUv, kMaxUv);
  for (std::size_t i = 0; i < 4; ++i)
    shared.uv[i] = glm::round((glm::clamp(card.uv[i], -kMaxUv, kMaxUv) - glm::floor(mean)) * kUvSteps) / kUvSteps;
  return shared;
}

double squared_distance(const Card& a, const Card& b) {
  if (a.material != b.material) return kFar;
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec2 step(a.uv[i] - b.uv[i]);
    sum += glm::dot(step, step);
  }
  return sum;
}

/// Merges equal cards; the distinct ones are in order of first use.
SharedCards merge_equal(const std::vector<Card>& cards, const std::vector<Material>& materials) {
  SharedCards merged;
  std::map<std::pair<std::uint32_t, std::array<float, 8>>, std::uint32_t> index_of;  // by material and uvs
  for (const Card& card : cards) {
    const Card shared = canonical(card, materials);
    const auto [found, is_new] = index_of.try_emplace({shared.material, std::bit_cast<std::array<float, 8>>(shared.uv)},
                                                      static_cast<std::uint32_t>(merged.table.size()));
    if (is_new) merged.table.push_back(shared);
    merged.card_of.push_back(found->second);
  }
  return merged;
}

/// Farthest-point sampling: the worst leaf is as near to its card as this many cards allow, up to a factor of two. A material that is not
/// in the table yet is infinitely far, so each material gets a card.
SharedCards choose(const SharedCards& all) {
  SharedCards chosen;
  std::vector<double> gaps(all.table.size(), kFar);
  std::vector<std::uint32_t> nearest(all.table.size(), 0);
  while (chosen.table.size() < COPPICE_MAX_CARDS) {
    const auto farthest = static_cast<std::size_t>(std::max_element(gaps.begin(), gaps.end()) - gaps.begin());
    const auto number = static_cast<std::uint32_t>(chosen.table.size());
    chosen.table.push_back(all.table[farthest]);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      const double gap = squared_distance(all.table[i], chosen.table.back());
      if (gap >= gaps[i]) continue;
      gaps[i] = gap;
      nearest[i] = number;
    }
  }
  for (const std::uint32_t card : all.card_of) chosen.card_of.push_back(nearest[card]);
  return chosen;
}

}  // namespace

SharedCards share_cards(const std::vector<Card>& cards, const std::vector<Material>& materials) {
  SharedCards merged = merge_equal(cards, materials);
  if (merged.table.size() <= COPPICE_MAX_CARDS) return merged;
  return choose(merged);
}

}  // namespace coppice::bake
