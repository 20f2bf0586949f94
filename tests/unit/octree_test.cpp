#include "octree.h"

#include <algorithm>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "quad_merge.h"
#include "test_foliage.h"

namespace coppice::bake::octree_test {

using Ids = std::vector<std::uint32_t>;

/// Small squares whose centroids are the given points, and two that pin the box to [0, 8]^3.
Foliage at(const std::vector<glm::vec3>& points) {
  std::vector<Quad> quads;
  for (const glm::vec3& p : points) quads.push_back(Quad{p, p, p, p});
  quads.push_back(Quad{glm::vec3(0), glm::vec3(8), glm::vec3(0), glm::vec3(8)});
  return test::plain_foliage(quads);
}

Ids candidates(LeafOctree& octree, std::uint32_t id, std::uint32_t count) {
  Ids found;
  octree.candidates_of(id, count, found);
  return found;
}

Ids cell_candidates(LeafOctree& octree, std::uint32_t id, std::uint32_t count) {
  Ids found;
  octree.cell_candidates_of(id, count, found);
  return found;
}

LeafOctree octree_of(const std::vector<glm::vec3>& points) {
  LeafOctree octree(at(points), static_cast<std::uint32_t>(points.size()));
  for (std::uint32_t i = 0; i < points.size(); ++i) octree.insert(i, points[i]);
  return octree;
}

TEST(LeafOctree, GrowsCellByCellAndKeepsTheNearest) {
  // Seven leaves in all: depth 2 + ceil(log2(7) / 3) = 3, cells of 1 m.
  LeafOctree octree =
      octree_of({{0.1f, 0.1f, 0.1f}, {1.9f, 1.9f, 1.9f}, {2.1f, 0.1f, 0.1f}, {3.9f, 3.9f, 3.9f}, {4.1f, 0.1f, 0.1f}, {7.9f, 7.9f, 7.9f}});
  // The own cell has no other; the first ring has leaf 1, though leaf 2 is nearer.
  EXPECT_EQ(candidates(octree, 0, 1), (Ids{1}));
  EXPECT_EQ(cell_candidates(octree, 0, 1), (Ids{1}));
  // The second ring brings 2, the third 3.
  EXPECT_EQ(candidates(octree, 0, 2), (Ids{2, 1}));
  EXPECT_EQ(cell_candidates(octree, 0, 2), (Ids{1, 2}));
  EXPECT_EQ(candidates(octree, 0, 3), (Ids{2, 1, 3}));
  // Level 2, cells of 2 m: two rings bring 4, the third 5.
  EXPECT_EQ(candidates(octree, 0, 4), (Ids{2, 1, 4, 3}));
  EXPECT_EQ(cell_candidates(octree, 0, 4), (Ids{1, 2, 3, 4}));
  EXPECT_EQ(candidates(octree, 0, 5), (Ids{2, 1, 4, 3, 5}));
  EXPECT_EQ(candidates(octree, 0, 50), (Ids{2, 1, 4, 3, 5}));
}

/// The paper weighs everything in the enlarged cell, however much that is.
TEST(LeafOctree, ACellOfManyGivesThemAll) {
  LeafOctree octree = octree_of(std::vector<glm::vec3>(40, glm::vec3(4.5f)));
  Ids others;
  for (std::uint32_t i = 0; i < 40; ++i)
    if (i != 7) others.push_back(i);
  EXPECT_EQ(cell_candidates(octree, 7, 8), others);
  EXPECT_EQ(candidates(octree, 7, 8), (Ids{0, 1, 2, 3, 4, 5, 6, 8}));
}

TEST(LeafOctree, TiesGoToTheSmallerId) {
  const std::vector<glm::vec3> points(5, glm::vec3(4.5f));
  LeafOctree octree(at(points), 5);
  for (const std::uint32_t i : {3u, 1u, 4u, 0u, 2u}) octree.insert(i, points[i]);
  EXPECT_EQ(candidates(octree, 2, 3), (Ids{0, 1, 3}));
}

TEST(LeafOctree, ALoneLeafHasNoCandidatesAndAFoliageWithoutExtentIsOneCell) {
  LeafOctree lone = octree_of({glm::vec3(1)});
  EXPECT_TRUE(candidates(lone, 0, 8).empty());
  const Foliage foliage = test::plain_foliage(std::vector<Quad>(3, Quad{glm::vec3(2), glm::vec3(2), glm::vec3(2), glm::vec3(2)}));
  LeafOctree octree(foliage, 3);
  for (std::uint32_t i = 0; i < 3; ++i) octree.insert(i, glm::dvec3(2));
  EXPECT_EQ(candidates(octree, 1, 8), (Ids{0, 2}));
}

/// Removed leaves never come back, inserted ones are found, and there are always as many as asked for while there are any.
TEST(LeafOctree, FollowsInsertionsAndRemovals) {
  const Foliage foliage = test::ball_crown(500, 1);
  LeafOctree octree(foliage, 1000);
  std::vector<bool> live(1000, false);
  std::size_t live_count = 0;
  const auto insert = [&](std::uint32_t id, const glm::dvec3& point) { octree.insert(id, point), live[id] = true, ++live_count; };
  for (std::uint32_t i = 0; i < 500; ++i) insert(i, quad_centroid(foliage.quads[i]));
  std::mt19937 random(2);
  std::uint32_t next = 500;
  while (live_count > 1) {
    auto id = static_cast<std::uint32_t>(random() % next);
    while (!live[id]) id = (id + 1) % next;
    const Ids found = candidates(octree, id, 8);
    ASSERT_EQ(found.size(), std::min<std::size_t>(8, live_count - 1));
    for (const std::uint32_t candidate : found) ASSERT_TRUE(live[candidate] && candidate != id);
    ASSERT_EQ(std::set<std::uint32_t>(found.begin(), found.end()).size(), found.size());
    octree.remove(id), live[id] = false, --live_count;
    if (next < 1000 && random() % 2 == 0) insert(next, quad_centroid(foliage.quads[next - 500])), ++next;
  }
}

}  // namespace coppice::bake::octree_test
