#include "leaf_reach.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "test_foliage.h"

namespace coppice::bake::leaf_reach_test {

const Quad kUnitSquare = test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});

TEST(LeafReach, OfPointsAboveBesideAndOffACorner) {
  EXPECT_DOUBLE_EQ(squared_reach({{0.25f, 0.5f, 2}}, kUnitSquare), 4.0);
  EXPECT_DOUBLE_EQ(squared_reach({{3, 0.5f, 0}}, kUnitSquare), 4.0);
  EXPECT_DOUBLE_EQ(squared_reach({{-3, -4, 0}}, kUnitSquare), 25.0);
  EXPECT_DOUBLE_EQ(squared_reach({{0.25f, 0.5f, 0}, {0.5f, 0.5f, -3}, {2, 0.5f, 0}}, kUnitSquare), 9.0);
  EXPECT_DOUBLE_EQ(squared_reach({{0, 3, 4}}, test::rectangle({0, 0, 0}, {0, 0, 0}, {0, 0, 0})), 25.0);
  EXPECT_DOUBLE_EQ(squared_reach(reach_points(kUnitSquare), kUnitSquare), 0.0);
}

TEST(LeafReach, KeepsTheOutermostPoints) {
  ReachPoints points = reach_points(kUnitSquare);
  for (std::uint32_t i = 0; i < 40; ++i) {
    const Foliage leaf = test::random_quads(1, i);
    points = merged_reach_points(points, reach_points(leaf.quads[0]));
    EXPECT_LE(points.size(), 14u);
  }
  ReachPoints others(15, glm::vec3(0.1f));
  others.insert(others.end(), {{9, 0, 0}, {0, -9, 0}});
  points = merged_reach_points(points, others);
  EXPECT_EQ(std::count(points.begin(), points.end(), glm::vec3(9, 0, 0)), 1);
  EXPECT_EQ(std::count(points.begin(), points.end(), glm::vec3(0, -9, 0)), 1);
  EXPECT_EQ(std::count(points.begin(), points.end(), glm::vec3(0.1f)), 0);
}

}  // namespace coppice::bake::leaf_reach_test
