#include "tree_order.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "collapse_information.h"
#include "quad_merge.h"
#include "results.h"
#include "test_foliage.h"
#include "viewpoints.h"

namespace coppice::bake::tree_order_test {

using Corners = std::array<std::uint8_t, 4>;

TEST(MergeCorners, Figure3) {
  // Two squares of side 1 side by side, 4 apart, the second turned by one corner:
  //   3 2       4 7
  //   0 1       5 6
  const Quad first{glm::vec3(0, 0, 0), {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const Quad second{glm::vec3(4, 1, 0), {4, 0, 0}, {5, 0, 0}, {5, 1, 0}};
  // Farthest: 0-7 and 3-6, sqrt(26); 0-7 is first. To 0 and 7, vertices 3 and 6 both have 1 + 5, the most (1: 1 + sqrt(17)): v3 = 3.
  // To 0, 7 and 3, vertex 6 has 5 + 1 + sqrt(26).
  EXPECT_EQ(merge_corners(first, second), (Corners{0, 3, 7, 6}));
  EXPECT_EQ(merged_quad(first, second, {0, 3, 7, 6}), (Quad{glm::vec3(0, 0, 0), {0, 1, 0}, {5, 1, 0}, {5, 0, 0}}));
}

TEST(MergeCorners, AreFourDifferentVerticesEvenWhenTheyCoincide) {
  const Quad point{glm::vec3(1), glm::vec3(1), glm::vec3(1), glm::vec3(1)};
  EXPECT_EQ(merge_corners(point, point), (Corners{0, 2, 1, 3}));
  const Quad square = test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  // 0-2 before its equals; 1 and 3 (and 5, 7) are equally far from both, then 3 and 7 (on top of it) from all three.
  EXPECT_EQ(merge_corners(square, square), (Corners{0, 1, 2, 3}));
}

TEST(MergedCard, IsThatOfTheLargerTheFirstOfEquals) {
  const Quad small = test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), large = test::rectangle({5, 0, 0}, {0, 2, 0}, {0, 0, 1});
  EXPECT_DOUBLE_EQ(quad_area(small), 1.0);
  EXPECT_DOUBLE_EQ(quad_area(large), 2.0);
  EXPECT_EQ(merged_card(small, 7, large, 9), 9u);
  EXPECT_EQ(merged_card(large, 9, small, 7), 9u);
  EXPECT_EQ(merged_card(small, 7, small, 9), 7u);
}

Foliage three_leaves() {
  return test::plain_foliage({test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), test::rectangle({9, 0, 0}, {3, 0, 0}, {0, 1, 0}),
                              test::rectangle({20, 0, 0}, {2, 0, 0}, {0, 1, 0})});
}

/// Three leaves in a row: 1 and 2 merge, then 0 and the result.
Tree tree_of_three(const Foliage& foliage) {
  return build_tree(foliage, CollapseSequence{{Merge{1, 2, {0, 1, 6, 7}, 9}, Merge{0, 3, {0, 1, 6, 7}, 4}}, 0});
}

TEST(TreeOrder, ThreeLeavesAndOne) {
  Foliage foliage = three_leaves();
  foliage.cards = {0, 1, 0};
  foliage.card_table.push_back(foliage.card_table[0]);
  const Tree tree = build_tree(foliage, CollapseSequence{{Merge{1, 2, {0, 3, 6, 5}}, Merge{0, 3, {0, 1, 7, 4}}}, 0});
  ASSERT_EQ(tree.leaf_count(), 3u);
  EXPECT_EQ(tree.split_parent, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(tree.node_split, (std::vector<std::uint32_t>{0, kNone, 1, kNone, kNone}));
  EXPECT_EQ(tree.node_source, (std::vector<std::uint32_t>{kNone, 0, kNone, 1, 2}));
  // Node 2 merges leaves 1 (vertices 4..7) and 2 (8..11); the root leaf 0 (0..3) and node 2.
  EXPECT_EQ(tree.nodes[2].vertices, (std::array<std::uint32_t, 4>{4, 7, 10, 9}));
  EXPECT_EQ(tree.nodes[0].vertices, (std::array<std::uint32_t, 4>{0, 1, 9, 4}));
  EXPECT_EQ(tree.nodes[2].card, 1u);  // leaf 1 is the larger
  EXPECT_EQ(tree.nodes[0].card, 1u);
  EXPECT_EQ(cut_nodes(tree, 1), (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(cut_nodes(tree, 2), (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(cut_nodes(tree, 3), (std::vector<std::uint32_t>{1, 3, 4}));

  const Tree one = build_tree(test::ball_crown(1, 4), CollapseSequence{});
  EXPECT_EQ(one.nodes.size(), 1u);
  EXPECT_TRUE(one.split_parent.empty());
  EXPECT_EQ(one.node_source, (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(cut_nodes(one, 1), (std::vector<std::uint32_t>{0}));
}

TEST(TreeOrder, CutsHaveTheOpacitiesOfTheirMerges) {
  const Foliage foliage = three_leaves();
  const Tree tree = tree_of_three(foliage);
  EXPECT_EQ(cut_foliage(tree, foliage.card_table, 1).opacities, (std::vector<std::uint8_t>{4}));
  EXPECT_EQ(cut_foliage(tree, foliage.card_table, 2).opacities, (std::vector<std::uint8_t>{kOpaque, 9}));
  EXPECT_EQ(cut_foliage(tree, foliage.card_table, 3).opacities, (std::vector<std::uint8_t>(3, kOpaque)));
  EXPECT_EQ(cut_foliage(tree, foliage.card_table, 3).quads, foliage.quads);

  const Foliage cut = cut_foliage(tree, foliage.card_table, 2), solid = solid_foliage(cut);
  EXPECT_EQ(solid.opacities, (std::vector<std::uint8_t>{kOpaque, kOpaque}));
  EXPECT_EQ(solid.quads[0], cut.quads[0]);
  EXPECT_NEAR(quad_area(solid.quads[1]), quad_area(cut.quads[1]) * 9 / 16, 1e-5);
  EXPECT_LT(glm::distance(quad_centroid(solid.quads[1]), quad_centroid(cut.quads[1])), 1e-5);
}

TEST(TreeOrder, NodesHaveTheNormalsOfTheirLeaves) {
  Foliage foliage = three_leaves();
  foliage.normals = {kFlatNormals, kFlatNormals, pack_normals(31, 31, 15, NormalSide::against)};
  for (const glm::dvec3& normal : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)})
    foliage.normal_sums.push_back(normal_sum(normal, 2.0));
  const Tree tree = tree_of_three(foliage);
  const auto root = cut_foliage(tree, foliage.card_table, 1).normals;
  EXPECT_EQ(root, (std::vector<std::uint16_t>{node_normals(foliage.normal_sums[0] + (foliage.normal_sums[1] + foliage.normal_sums[2]))}));
  EXPECT_EQ(along_step_of(root[0]), 5u) << "a third of each";
  EXPECT_EQ(cut_foliage(tree, foliage.card_table, 2).normals,
            (std::vector<std::uint16_t>{kFlatNormals, node_normals(foliage.normal_sums[1] + foliage.normal_sums[2])}));
  EXPECT_EQ(cut_foliage(tree, foliage.card_table, 3).normals, foliage.normals);
}

Tree baked_tree(const Foliage& foliage) {
  const auto result = test::must(collapse_by_mutual_information({foliage, test::plain_materials(), {}}, *viewpoints(6), {32, true, 4}, {}));
  return build_tree(foliage, result.sequence);
}

TEST(TreeOrder, EveryCutIsAPartitionOfTheSourceLeaves) {
  const Tree tree = baked_tree(test::ball_crown(100, 1));
  std::vector<std::uint32_t> parents(tree.nodes.size(), kNone);
  for (std::uint32_t s = 0; s < tree.split_parent.size(); ++s) parents[2 * s + 1] = parents[2 * s + 2] = tree.split_parent[s];
  for (std::uint32_t m = 1; m <= 100; ++m) {
    const std::vector<std::uint32_t> cut = cut_nodes(tree, m);
    ASSERT_EQ(cut.size(), m);
    ASSERT_TRUE(std::ranges::is_sorted(cut));
    ASSERT_LT(cut.back(), 2 * m - 1);
    std::set<std::uint32_t> covering;
    for (std::uint32_t node = 0; node < tree.nodes.size(); ++node) {
      if (tree.node_source[node] == kNone) continue;
      std::uint32_t ancestor_count = 0;
      for (std::uint32_t up = node; up != kNone; up = parents[up]) {
        if (!std::ranges::binary_search(cut, up)) continue;
        ++ancestor_count;
        covering.insert(up);
      }
      ASSERT_EQ(ancestor_count, 1u) << "node " << node << " in cut " << m;
    }
    ASSERT_EQ(covering.size(), m);  // no node of the cut is empty
  }
}

TEST(TreeOrder, NodesAreSourceLeavesOrHaveTwoChildrenWhoseVerticesTheyShare) {
  const Foliage foliage = test::ball_crown(100, 2);
  const Tree tree = baked_tree(foliage);
  ASSERT_EQ(tree.nodes.size(), 199u);
  ASSERT_EQ(tree.vertices.size(), 400u);
  std::set<std::uint32_t> sources;
  for (std::uint32_t node = 0; node < 199; ++node) {
    ASSERT_NE(tree.node_split[node] == kNone, tree.node_source[node] == kNone);
    if (tree.node_source[node] != kNone) {
      sources.insert(tree.node_source[node]);
      EXPECT_EQ(node_quad(tree, node), foliage.quads[tree.node_source[node]]);
      continue;
    }
    const std::uint32_t split = tree.node_split[node];
    ASSERT_EQ(tree.split_parent[split], node);
    ASSERT_LT(node, 2 * split + 1);
    std::multiset<std::uint32_t> of_children;
    for (const std::uint32_t child : {2 * split + 1, 2 * split + 2})
      of_children.insert(tree.nodes[child].vertices.begin(), tree.nodes[child].vertices.end());
    const std::set<std::uint32_t> own(tree.nodes[node].vertices.begin(), tree.nodes[node].vertices.end());
    ASSERT_EQ(own.size(), 4u);
    for (const std::uint32_t vertex : own) EXPECT_EQ(of_children.count(vertex), 1u);
  }
  EXPECT_EQ(sources.size(), 100u);
}

}  // namespace coppice::bake::tree_order_test
