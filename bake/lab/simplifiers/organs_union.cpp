#include "organs_union.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <string>
#include <tuple>

#include <glm/common.hpp>

#include "check.h"
#include "collapse_geometric.h"
#include "leaves_union.h"
#include "quad_merge.h"
#include "united_leaf.h"

namespace coppice::bake {
namespace {

using Group = std::vector<std::uint32_t>;

glm::vec3 stalk_of(const Quad& quad) {
  return 0.5f * (quad[0] + quad[3]);
}

/// Halves a group at the median along the longest side of the stalks' box.
std::pair<Group, Group> halved(const Foliage& foliage, Group leaves) {
  glm::vec3 low = stalk_of(foliage.quads[leaves[0]]), high = low;
  for (const std::uint32_t leaf : leaves) {
    low = glm::min(low, stalk_of(foliage.quads[leaf]));
    high = glm::max(high, stalk_of(foliage.quads[leaf]));
  }
  const glm::vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::ranges::sort(leaves, [&](std::uint32_t a, std::uint32_t b) {
    const float first = stalk_of(foliage.quads[a])[axis], second = stalk_of(foliage.quads[b])[axis];
    return first != second ? first < second : a < b;
  });
  const auto middle = leaves.begin() + static_cast<std::ptrdiff_t>((leaves.size() + 1) / 2);
  return {Group(leaves.begin(), middle), Group(middle, leaves.end())};
}

/// The unions of one level of the hierarchy: only pairs within a group.
class OrgansUnion {
 public:
  OrgansUnion(const Foliage& foliage, std::uint32_t max_size)
      : leaf_size_m_(mean_leaf_size_m(foliage)), leaves_(united_leaves(foliage)), live_(leaves_.size(), true) {
    live_count_ = foliage.leaf_count();
    groups_ = stalk_groups(foliage, max_size);
    open_floor();
  }

  [[nodiscard]] std::uint32_t live_count() const { return live_count_; }

  [[nodiscard]] std::vector<UnitedLeaf> live_leaves() const {
    std::vector<UnitedLeaf> leaves;
    for (std::size_t id = 0; id < leaves_.size(); ++id)
      if (live_[id]) leaves.push_back(leaves_[id]);
    return leaves;
  }

  /// Unites the cheapest pair. At least two leaves must be live.
  void step() {
    while (bests_.empty()) next_floor();
    const auto [cost, first, second, group] = bests_.top();
    bests_.pop();
    const UnitedLeaf &a = leaves_[first], &b = leaves_[second];
    const UnitedLeaf united{united_rectangle(a.quad, b.quad, RectangleLength::similar), merged_card(a.quad, a.card, b.quad, b.card)};
    live_[first] = live_[second] = false;
    const auto id = static_cast<std::uint32_t>(leaves_.size());
    leaves_.push_back(united);
    live_.push_back(true);
    --live_count_;
    std::erase_if(groups_[group], [&](std::uint32_t leaf) { return !live_[leaf]; });
    groups_[group].push_back(id);
    push_best(group);
  }

 private:
  /// (cost, smaller id, larger id, group)
  using Best = std::tuple<double, std::uint32_t, std::uint32_t, std::size_t>;

  void push_best(std::size_t group) {
    const Group& leaves = groups_[group];
    std::optional<Best> best;
    for (std::size_t i = 0; i < leaves.size(); ++i)
      for (std::size_t j = i + 1; j < leaves.size(); ++j) {
        constexpr double kAngleWeight = 1.0;
        const auto [first, second] = std::minmax(leaves[i], leaves[j]);
        const Best pair{leaves_union_cost(leaves_[first].quad, leaves_[second].quad, kAngleWeight, leaf_size_m_), first, second, group};
        if (!best || pair < *best) best = pair;
      }
    if (best) bests_.push(*best);
  }

  void open_floor() {
    for (std::size_t group = 0; group < groups_.size(); ++group) push_best(group);
  }

  /// Goes up one level: two neighbouring groups become one.
  void next_floor() {
    COPPICE_ASSERT(groups_.size() > 1);
    std::vector<Group> wholes;
    for (std::size_t i = 0; i < groups_.size(); i += 2) {
      wholes.push_back(groups_[i]);
      if (i + 1 < groups_.size()) wholes.back().insert(wholes.back().end(), groups_[i + 1].begin(), groups_[i + 1].end());
    }
    groups_ = std::move(wholes);
    open_floor();
  }

  double leaf_size_m_;
  std::vector<UnitedLeaf> leaves_;  ///< [id]
  std::vector<bool> live_;          ///< [id]
  std::uint32_t live_count_ = 0;
  std::vector<Group> groups_;
  std::priority_queue<Best, std::vector<Best>, std::greater<>> bests_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> stalk_groups(const Foliage& foliage, std::uint32_t max_size) {
  COPPICE_ASSERT(max_size >= 1 && foliage.leaf_count() >= 1);
  std::vector<Group> groups(1, Group(foliage.leaf_count()));
  std::iota(groups[0].begin(), groups[0].end(), 0u);
  while (groups[0].size() > max_size) {  // the first is the largest: an odd leaf stays in the first half
    std::vector<Group> halves;
    for (Group& group : groups) {
      auto [first, second] = halved(foliage, std::move(group));
      halves.push_back(std::move(first));
      halves.push_back(std::move(second));
    }
    groups = std::move(halves);
  }
  return groups;
}

std::vector<Variant> unite_organs(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts) {
  std::vector<Variant> variants;
  for (const std::uint32_t max_size : {4u, 8u, 16u, 32u, 64u}) {
    Variant variant;
    variant.parameters = "groups of " + std::to_string(max_size);
    variant.levels.resize(leaf_counts.size());
    OrgansUnion united(foliage, max_size);
    const std::uint32_t last = *std::ranges::min_element(leaf_counts);
    for (;; united.step()) {
      for (std::size_t i = 0; i < leaf_counts.size(); ++i)
        if (leaf_counts[i] == united.live_count()) variant.levels[i] = level_of(united.live_leaves(), foliage.card_table);
      if (united.live_count() == last) break;
    }
    variants.push_back(std::move(variant));
  }
  return variants;
}

}  // namespace coppice::bake
