// Plants in a gale look whole: leaves stay on their twigs, crowns do not breathe, and yet they move.

#include "wind_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "coppice/format.h"
#include "generate_plant.h"
#include "import_gltf.h"
#include "plant_grower.h"
#include "plants_folder.h"
#include "results.h"

namespace coppice::test::wind_figures_test {

void expect_whole(const WindFigures& of) {
  // What is beside a stem that slopes comes a little nearer to it, or goes farther.
  EXPECT_LE(of.gap_99, 0.02 + 0.15 * of.bend_share) << "of a leaf's length";
  // Where a stem slopes by q, 1 - q^2 / 2 of its height is left; the top's slope is twice the share that it bends by.
  const double lower = 2.0 * of.bend_share * of.bend_share;
  EXPECT_LE(of.volume_max, 0.03 + lower);
  EXPECT_LE(of.squeeze_max, 0.1 + lower);
  EXPECT_LE(of.reach_m, COPPICE_MAX_WIND_MOVE * of.radius_m);
  EXPECT_LE(of.move_max_m, of.reach_m * 1.0001);
}

class GrownInWind : public testing::TestWithParam<const char*> {};

TEST_P(GrownInWind, LeavesStayOnTheirTwigs) {
  auto plant = must(bake::generate_plant(GetParam(), 1));
  const WindFigures of = wind_figures(std::move(plant), 300);
  expect_whole(of);
  EXPECT_GE(of.move_max_m, 0.01 * of.radius_m) << "it moves";
}

INSTANTIATE_TEST_SUITE_P(Species, GrownInWind, testing::Values("corylus", "willow", "juniper"),
                         [](const auto& species) { return std::string(species.param); });

class ForeignInWind : public testing::TestWithParam<const char*> {};

TEST_P(ForeignInWind, LeavesStayOnTheirTwigs) {
  COPPICE_PLANT_OR_SKIP(path, GetParam() + std::string(".glb"));
  auto plant = must(bake::import_gltf(path, {}));
  expect_whole(wind_figures(std::move(plant), 300));
}

INSTANTIATE_TEST_SUITE_P(Plants, ForeignInWind, testing::Values("eztree_oak_medium", "eztree_pine_large", "scopia_poplar", "coffee"),
                         [](const auto& plant) { return std::string(plant.param); });

using bake::test::Grower;

/// leaves: shapes of so many triangles each
bake::Plant plant_of(Grower& wood, Grower& leaves, std::uint32_t triangles_of_leaf) {
  bake::Plant plant;
  plant.materials.resize(1);
  plant.wood = wood.take().soup.mesh;
  plant.foliage = leaves.take().soup.mesh;
  for (std::uint32_t i = 0; 3 * i < plant.foliage.indices.size(); i += triangles_of_leaf) plant.leaves.push_back({i, triangles_of_leaf});
  return plant;
}

/// 10 m high, with boughs and twigs of leaves.
bake::Plant tree() {
  Grower wood("", 0), leaves("", 0);
  wood.paint("", bake::test::kBrown);
  leaves.paint("", bake::test::kGreen);
  std::vector<glm::vec3> centers;
  std::vector<float> radii_m;
  for (int i = 0; i <= 24; ++i) {
    centers.push_back(10.0f / 24.0f * static_cast<float>(i) * bake::test::kUp);
    radii_m.push_back(0.11f - 0.0042f * static_cast<float>(i));
  }
  wood.lathe(centers, radii_m, 8);
  for (int i = 0; i < 60; ++i) {
    const glm::vec3 out = bake::test::round_about(bake::test::kGoldenAngle * static_cast<float>(i), 0.2f);
    const float height_m = 1.5f + 0.135f * static_cast<float>(i), length_m = 0.28f * (10.5f - height_m);
    const glm::vec3 foot = height_m * bake::test::kUp;
    std::vector<glm::vec3> joints;
    for (int k = 0; k <= 10; ++k) joints.push_back(foot + 0.1f * static_cast<float>(k) * length_m * out);
    wood.lathe(joints, {0.02f, 0.018f, 0.016f, 0.014f, 0.012f, 0.01f, 0.009f, 0.008f, 0.007f, 0.006f, 0.005f}, 5);
    for (int k = 2; k < 30; ++k)
      leaves.blade({.root = foot + static_cast<float>(k) / 30.0f * length_m * out,
                    .along = bake::test::round_about(static_cast<float>(k), 0.3f),
                    .length_m = 0.15f,
                    .width_m = 0.06f,
                    .segment_count = 2});
  }
  return plant_of(wood, leaves, 3);
}

/// A stalk of 2 m that is one long tube, with long leaves: maize.
bake::Plant stalk() {
  Grower wood("", 0), leaves("", 0);
  wood.paint("", bake::test::kGreen).tube({0, 0, 0}, {0, 2, 0}, 0.012f);
  leaves.paint("", bake::test::kGreen);
  for (int i = 0; i < 14; ++i) {
    const glm::vec3 out = bake::test::round_about(3.3f * static_cast<float>(i), 1.0f);
    leaves.blade({.root = (0.3f + 0.12f * static_cast<float>(i)) * bake::test::kUp + 0.01f * out,
                  .along = out,
                  .length_m = 0.7f,
                  .width_m = 0.08f,
                  .bend = 1.2f,
                  .segment_count = 6});
  }
  return plant_of(wood, leaves, 11);
}

bake::Plant tuft() {
  Grower wood("", 0), leaves("", 0);
  leaves.paint("", bake::test::kGreen);
  for (int i = 0; i < 80; ++i) {
    const float turn = bake::test::kGoldenAngle * static_cast<float>(i);
    leaves.blade({.root = 0.01f * std::sqrt(static_cast<float>(i)) * bake::test::round_about(turn, 0.0f),
                  .along = bake::test::round_about(turn, 4.0f),
                  .length_m = leaves.between(0.3f, 0.5f),
                  .width_m = 0.008f,
                  .bend = 0.4f,
                  .segment_count = 5});
  }
  return plant_of(wood, leaves, 9);
}

/// A strong wind of 15 m/s moves tops of trees by 2 to 5 % of their height, those of crops and grasses by 10 to 40 %; less wind less.
TEST(BendingInWind, IsThatOfTreesAndOfGrasses) {
  struct Case {
    const char* name;
    bake::Plant (*grow)();
    double low, high;
  };
  for (const Case& each : {Case{"tree", tree, 0.02, 0.05}, {"stalk", stalk, 0.1, 0.4}, {"tuft", tuft, 0.1, 0.4}}) {
    const WindFigures of = wind_figures(each.grow(), 300);
    EXPECT_GE(of.tip_shares[2], each.low) << each.name;
    EXPECT_LE(of.tip_shares[2], each.high) << each.name;
    EXPECT_LT(of.tip_shares[1], 0.7 * of.tip_shares[2]) << each.name;
    EXPECT_LT(of.tip_shares[0], 0.4 * of.tip_shares[2]) << each.name;
    EXPECT_GT(of.tip_shares[0], 0.05 * of.tip_shares[2]) << each.name << " moves in a breeze too";
    // Bending by a share of the height slopes the top by twice that, q: of a length that lies askew sqrt(1 - q) is left, or sqrt(1 + q).
    EXPECT_LE(of.stretch_max, 1.0 - std::sqrt(1.0 - 2.0 * of.tip_shares[2]) + COPPICE_MAX_WIND_GROWTH) << each.name;
    EXPECT_LE(of.gap_99, 0.02) << each.name;
    EXPECT_LE(of.volume_max, 0.25) << each.name;
    EXPECT_LE(of.squeeze_max, 0.3) << each.name << ": nothing folds";
    EXPECT_LE(of.move_max_m, COPPICE_MAX_WIND_MOVE * of.radius_m) << each.name;
  }
}

}  // namespace coppice::test::wind_figures_test
