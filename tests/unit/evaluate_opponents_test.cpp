#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "leaf_unions.h"
#include "lines_and_voxels.h"
#include "quad_merge.h"
#include "results.h"
#include "test_foliage.h"

namespace coppice::bake::evaluate_opponents_test {

/// In the plane z = 0.
Quad flat(float x, float y, float width, float height) {
  return test::rectangle({x, y, 0}, {width, 0, 0}, {0, height, 0});
}

const Quad kUpright = test::rectangle({0, 0, 0}, {0, 1, 0}, {0, 0, 1});

TEST(Fsa, ErrorWeighsAngleAndDistance) {
  EXPECT_DOUBLE_EQ(fsa_error(flat(0, 0, 1, 1), flat(0, 0, 1, 1), 0.5, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(fsa_error(flat(0, 0, 1, 1), flat(3, 4, 1, 1), 0.25, 2.0), 0.75 * 2.5);
  EXPECT_DOUBLE_EQ(fsa_error(flat(-0.5f, 0, 1, 1), kUpright, 0.75, 1.0), 0.75 + 0.25 * 0.5) << "at right angles, 1/2 apart";
}

TEST(Fsa, TwoHalvesOfARectangleBecomeItAndFarLeavesKeepTheirArea) {
  const Quad joined = area_keeping_quad(flat(0, 0, 1, 1), flat(1, 0, 1, 1));
  EXPECT_DOUBLE_EQ(quad_area(joined), 2.0);
  EXPECT_EQ(quad_centroid(joined), glm::dvec3(1, 0.5, 0));
  const Quad first = flat(0, 0, 1, 1), second = flat(8, 0, 1, 1);
  const double kept = quad_area(area_keeping_quad(first, second)),
               farthest = quad_area(merged_quad(first, second, merge_corners(first, second)));
  EXPECT_LT(std::abs(kept - 2.0), std::abs(farthest - 2.0));
}

TEST(LeavesUnion, CostIsDiameterAngleAndSize) {
  // Side by side: diameter sqrt(5). One of them twice as wide: sqrt(1 + 9), areas 1 and 2.
  EXPECT_NEAR(leaves_union_cost(flat(0, 0, 1, 1), flat(1, 0, 1, 1), 1.0, 1.0), std::sqrt(5.0), 1e-12);
  EXPECT_NEAR(leaves_union_cost(flat(0, 0, 1, 1), flat(1, 0, 2, 1), 1.0, 2.0), std::sqrt(10.0) / 2 + 1.0 / 3, 1e-12);
}

TEST(LeavesUnion, ARectangleHasTheAreaOfBothAboutTheirMiddle) {
  // Diagonal (0, 0) to (3, 1); areas 1 and 2, centres (0.5, 0.5) and (2, 0.5).
  for (const RectangleLength length : {RectangleLength::extent, RectangleLength::similar}) {
    const Quad quad = united_rectangle(flat(0, 0, 1, 1), flat(1, 0, 2, 1), length);
    EXPECT_NEAR(quad_area(quad), 3.0, 1e-5);
    EXPECT_NEAR(glm::distance(quad_centroid(quad), glm::dvec3(1.5, 0.5, 0)), 0.0, 1e-6);
    EXPECT_NEAR(quad_normal(quad).z, 1.0, 1e-6);
    const double ratio = glm::distance(quad[0], quad[1]) / glm::distance(quad[1], quad[2]);
    if (length == RectangleLength::similar) {
      EXPECT_NEAR(ratio, 2.0, 1e-5) << "the larger is 2 : 1";
    } else {
      EXPECT_NEAR(glm::distance(quad[0], quad[1]), std::sqrt(10.0), 1e-5) << "as long as the diagonal";
    }
  }
}

TEST(OrgansUnion, StalksAreHalvedAtTheMedian) {
  std::vector<Quad> quads;
  for (const float x : {7.0f, 0.0f, 3.0f, 1.0f, 5.0f, 2.0f}) quads.push_back(flat(x, 0, 0.5f, 0.5f));
  const auto groups = stalk_groups(test::plain_foliage(quads), 2);
  EXPECT_EQ(groups, (std::vector<std::vector<std::uint32_t>>{{1, 3}, {5}, {2, 4}, {0}}));
  EXPECT_EQ(stalk_groups(test::plain_foliage(quads), 6).size(), 1u);
}

TEST(OrgansUnion, AGroupIsOneLeafBeforeItMeetsAnother) {
  // 2 is nearer to 1 than 0 is, but belongs to 3.
  const Foliage foliage = test::plain_foliage({flat(0, 0, 1, 1), flat(3, 0, 1, 1), flat(4, 0, 1, 1), flat(9, 0, 1, 1)});
  for (const Variant& variant : unite_organs(foliage, {2})) {
    if (variant.parameters != "groups of 4") continue;
    const Mesh& mesh = variant.levels[0].mesh;
    EXPECT_EQ(mesh.triangle_materials.size(), 4u);
  }
  const auto groups = stalk_groups(foliage, 2);
  EXPECT_EQ(groups, (std::vector<std::vector<std::uint32_t>>{{0, 1}, {2, 3}}));
}

TEST(NeedleLines, ALineRunsAlongTheLongerSideAndKeepsTheArea) {
  const Needle needle = needle_of(flat(0, 0, 4, 1), 2, 0.5);
  EXPECT_EQ(needle.from, glm::vec3(0, 0.5f, 0));
  EXPECT_EQ(needle.to, glm::vec3(4, 0.5f, 0));
  EXPECT_FLOAT_EQ(needle.width_m, 0.5f);
  EXPECT_EQ(needle.material, 2u);
  EXPECT_EQ(needle_of(flat(0, 0, 1, 4), 0, 1.0).to, glm::vec3(0.5f, 4, 0));
}

TEST(NeedleLines, TwoBecomeOneWithTheirArea) {
  // Opposite directions, areas 0.4 and 1.2: the middle is at (0.4 * 1 + 1.2 * 5) / 1.6 = 4.
  const Needle first{{0, 0, 0}, {2, 0, 0}, 0.2f, 0}, second{{7, 0, 0}, {3, 0, 0}, 0.3f, 1};
  const Needle longer = united_needle(first, second, NeedleLength::longer), both = united_needle(first, second, NeedleLength::both);
  EXPECT_NEAR(glm::distance(longer.from, longer.to), 4.0f, 1e-5);
  EXPECT_NEAR(longer.width_m, 0.4f, 1e-6);
  EXPECT_EQ(longer.material, 1u);
  EXPECT_NEAR(0.5f * (longer.from.x + longer.to.x), 4.0f, 1e-5);
  EXPECT_NEAR(glm::distance(both.from, both.to), 7.0f, 1e-5);
  EXPECT_NEAR(both.width_m, 1.6f / 7.0f, 1e-6);
}

TEST(CardCoverage, IsTheShareWithoutHoles) {
  std::vector<Material> materials = test::plain_materials();
  materials[0].image = 0;
  materials[0].alpha_cutoff = 0.5f;
  const std::vector<Image> images{{2, 2, {0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0, 255, 0, 0, 0, 255}}};
  const auto coverage = test::must(card_coverage(test::plain_foliage({}).card_table, materials, images));
  EXPECT_EQ(coverage, std::vector<double>{0.75});
  EXPECT_EQ(quad_point(flat(1, 2, 4, 8), 0.5, 0.25), glm::dvec3(3, 4, 0));
}

TEST(VoxelCloud, ACubeHoldsTheAreaByNormal) {
  // Two cells along x: the first has a leaf that faces z, the second one that faces x.
  const Foliage foliage = test::plain_foliage({flat(0, 0, 1, 1), test::rectangle({2, 0, 0}, {0, 1, 0}, {0, 0, 1})});
  const auto voxels = test::must(fill_voxels({foliage, test::plain_materials(), {}}, 2));
  ASSERT_EQ(voxels.size(), 2u);
  EXPECT_EQ(voxels[0].center, glm::vec3(0.5f, 0.5f, 0.5f));
  EXPECT_FLOAT_EQ(voxels[0].half_m, 0.5f);
  EXPECT_NEAR(voxels[0].area_m2[2], 1.0f, 1e-5);
  EXPECT_NEAR(voxels[1].area_m2[0], 1.0f, 1e-5);
  EXPECT_EQ(voxels[1].area_m2[2], 0.0f);
  const auto whole = fill_voxels({foliage, test::plain_materials(), {}}, 1);
  ASSERT_EQ(whole->size(), 1u);
  EXPECT_NEAR((*whole)[0].area_m2[0] + (*whole)[0].area_m2[2], 2.0f, 1e-5);
}

}  // namespace coppice::bake::evaluate_opponents_test
