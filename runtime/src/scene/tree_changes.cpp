#include "tree_changes.h"

#include <algorithm>

namespace coppice {

// Grows by half, so that trees may be felled one by one.
std::size_t TreeChanges::room_for(std::size_t added) const {
  const std::size_t now = changes_.items.size(), needed = changes_.count + added;
  return needed <= now ? now : std::max(needed, now + now / 2);
}

void TreeChanges::add(std::span<const coppice_scene_tree> trees, coppice_scene scene) {
  const std::size_t known = changes_.count;
  for (const coppice_scene_tree& tree : trees) {
    if (tree.scene != scene) continue;
    const std::span<TreeChange> sorted = changes_.span().first(known);
    const std::tuple key(tree.tile, tree.number);
    if (std::ranges::binary_search(sorted, key, {}, &TreeChange::key)) continue;
    changes_.push_back({.tile = tree.tile, .number = tree.number});
  }
  const std::span<TreeChange> all = changes_.span(), added = all.subspan(known);
  std::ranges::sort(added, {}, &TreeChange::key);
  const auto same = [](const TreeChange& a, const TreeChange& b) { return a.key() == b.key(); };
  changes_.count = known + static_cast<std::size_t>(std::unique(added.begin(), added.end(), same) - added.begin());
  std::ranges::inplace_merge(changes_.span(), changes_.span().begin() + static_cast<std::ptrdiff_t>(known), {}, &TreeChange::key);
}

void TreeChanges::tidy() {
  changes_.erase_if([](const TreeChange& change) { return change.state == COPPICE_TREE_AS_IN_FILE; });
}

TreeChange* TreeChanges::find(std::uint32_t tile, std::uint32_t number) {
  const std::span<TreeChange> all = changes_.span();
  const auto it = std::ranges::lower_bound(all, std::tuple(tile, number), {}, &TreeChange::key);
  return it != all.end() && it->key() == std::tuple(tile, number) ? &*it : nullptr;
}

std::span<TreeChange> TreeChanges::of_tile(std::uint32_t tile) {
  const std::span<TreeChange> all = changes_.span();
  return {std::ranges::lower_bound(all, tile, {}, &TreeChange::tile), std::ranges::upper_bound(all, tile, {}, &TreeChange::tile)};
}

}  // namespace coppice
