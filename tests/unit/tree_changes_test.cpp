// The list of trees that are not as in the file, against a map.

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "tree_changes.h"

namespace coppice::tree_changes_test {

constexpr coppice_scene kScene = 3;
using Key = std::pair<std::uint32_t, std::uint32_t>;

TEST(TreeChanges, HoldWhatAMapHoldsInItsOrder) {
  std::mt19937 random(5);
  const auto below = [&random](std::uint32_t end) { return std::uniform_int_distribution<std::uint32_t>(0, end - 1)(random); };
  TreeChanges changes;
  std::map<Key, coppice_tree_state> reference;
  for (int round = 0; round < 300; ++round) {
    std::vector<coppice_scene_tree> trees(below(12));
    for (coppice_scene_tree& tree : trees) tree = {below(4) == 0 ? kScene + 1 : kScene, below(9), below(40)};
    const std::uint64_t before = changes.bytes(), growth = changes.growth_bytes(trees.size());
    ASSERT_TRUE(changes.reserve(default_allocator(), trees.size()));
    EXPECT_EQ(changes.bytes(), before + growth);
    changes.add(trees, kScene);
    for (const coppice_scene_tree& tree : trees) {
      if (tree.scene != kScene) continue;
      TreeChange* change = changes.find(tree.tile, tree.number);
      ASSERT_NE(change, nullptr);
      change->state = below(3) == 0 ? COPPICE_TREE_AS_IN_FILE : COPPICE_TREE_HIDDEN;
      reference[{tree.tile, tree.number}] = change->state;
    }
    if (below(3) == 0) {
      changes.tidy();
      std::erase_if(reference, [](const auto& entry) { return entry.second == COPPICE_TREE_AS_IN_FILE; });
    }
    ASSERT_EQ(changes.all().size(), reference.size());
    auto next = reference.begin();
    for (const TreeChange& change : changes.all()) {
      EXPECT_EQ(Key(change.tile, change.number), next->first);
      EXPECT_EQ(change.state, (next++)->second);
    }
    for (std::uint32_t tile = 0; tile < 10; ++tile) {
      std::size_t count = 0;
      for (const auto& [key, state] : reference) count += key.first == tile ? 1u : 0u;
      EXPECT_EQ(changes.of_tile(tile).size(), count);
      for (const TreeChange& change : changes.of_tile(tile)) EXPECT_EQ(change.tile, tile);
    }
    EXPECT_EQ(changes.find(3, 41), nullptr);
  }
}

}  // namespace coppice::tree_changes_test
