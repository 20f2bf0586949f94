#pragma once

// The greedy union of leaves or other items without views: the cheapest pair goes first, and each item has one best partner among its
// neighbours.

#include <algorithm>
#include <compare>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "check.h"
#include "octree.h"
#include "plant.h"

namespace coppice::bake {

template <class Item>
struct UnionRules {
  std::function<double(const Item&, const Item&)> cost;
  std::function<Item(const Item&, const Item&)> unite;
  std::function<glm::dvec3(const Item&)> middle;  ///< neighbours are near each other by this
  std::uint32_t neighbour_count = 16;
};

/// Unites items step by step. Items have ids 0 .. N - 1, the result of step i has N + i. Ties go to the smaller ids. Runs on one thread.
template <class Item>
class GreedyUnion {
 public:
  /// source  its box holds the items' centres
  GreedyUnion(const Foliage& source, std::vector<Item> items, UnionRules<Item> rules)
      : rules_(std::move(rules)),
        items_(std::move(items)),
        live_(items_.size(), true),
        live_count_(static_cast<std::uint32_t>(items_.size())),
        octree_(source, 2 * live_count_) {
    for (std::uint32_t id = 0; id < live_count_; ++id) octree_.insert(id, rules_.middle(items_[id]));
    for (std::uint32_t id = 0; id < live_count_; ++id) find_partner(id);
  }

  [[nodiscard]] std::uint32_t live_count() const { return live_count_; }

  [[nodiscard]] const Item& item(std::uint32_t id) const { return items_[id]; }
  /// Pairs whose cost was computed.
  [[nodiscard]] std::uint64_t evaluations() const { return evaluations_; }

  /// [live items] in the order of ids
  [[nodiscard]] std::vector<Item> live_items() const {
    std::vector<Item> items;
    for (std::size_t id = 0; id < items_.size(); ++id)
      if (live_[id]) items.push_back(items_[id]);
    return items;
  }

  /// Unites the cheapest pair and returns their ids, the smaller first. At least two items must be live.
  std::pair<std::uint32_t, std::uint32_t> step() {
    const auto [cost, first, second, item] = cheapest_pair();
    for (const std::uint32_t id : {first, second}) {
      octree_.remove(id);
      live_[id] = false;
    }
    const auto united = static_cast<std::uint32_t>(items_.size());
    items_.push_back(rules_.unite(items_[first], items_[second]));
    live_.push_back(true);
    --live_count_;
    octree_.insert(united, rules_.middle(items_[united]));
    find_partner(united);
    return {first, second};
  }

 private:
  /// An item's best partner at the last search, in the order in which pairs are united.
  struct Pair {
    double cost = 0.0;
    std::uint32_t first = 0, second = 0;  ///< first < second
    std::uint32_t item = 0;               ///< the one of them that searched
    auto operator<=>(const Pair&) const = default;
  };

  /// Finds the cheapest pair. A pair whose item is gone is dropped; an item whose partner is gone searches again.
  Pair cheapest_pair() {
    for (;;) {
      COPPICE_ASSERT(!pairs_.empty());
      const Pair pair = pairs_.top();
      pairs_.pop();
      if (live_[pair.first] && live_[pair.second]) return pair;
      if (live_[pair.item]) find_partner(pair.item);
    }
  }

  void find_partner(std::uint32_t id) {
    octree_.candidates_of(id, rules_.neighbour_count, neighbours_);
    double lowest = std::numeric_limits<double>::infinity();
    std::uint32_t partner = kNone;
    for (const std::uint32_t other : neighbours_) {
      const double cost = rules_.cost(items_[id], items_[other]);
      if (cost < lowest || (cost == lowest && other < partner)) lowest = cost, partner = other;
    }
    evaluations_ += neighbours_.size();
    if (partner != kNone) pairs_.push({lowest, std::min(id, partner), std::max(id, partner), id});
  }

  UnionRules<Item> rules_;
  std::vector<Item> items_;  ///< [id]
  std::vector<bool> live_;   ///< [id]
  std::uint32_t live_count_;
  LeafOctree octree_;
  std::priority_queue<Pair, std::vector<Pair>, std::greater<>> pairs_;
  std::vector<std::uint32_t> neighbours_;
  std::uint64_t evaluations_ = 0;
};

/// The live items at each count, in the order of `counts`; each count 1 .. live_count() (asserted). Unions  such as GreedyUnion
template <class Unions>
auto unite_to(Unions unions, const std::vector<std::uint32_t>& counts) {
  std::vector<decltype(unions.live_items())> levels(counts.size());
  const std::uint32_t last = *std::ranges::min_element(counts);
  COPPICE_ASSERT(last >= 1 && *std::ranges::max_element(counts) <= unions.live_count());
  for (;; unions.step()) {
    for (std::size_t i = 0; i < counts.size(); ++i)
      if (counts[i] == unions.live_count()) levels[i] = unions.live_items();
    if (unions.live_count() == last) return levels;
  }
}

}  // namespace coppice::bake
