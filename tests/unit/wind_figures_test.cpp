// Plants in a gale look whole: leaves stay on their twigs, crowns do not breathe, and yet they move.

#include "wind_figures.h"

#include <gtest/gtest.h>

#include <string>

#include "coppice/format.h"
#include "generate_plant.h"
#include "import_gltf.h"
#include "plants_folder.h"
#include "results.h"

namespace coppice::test {
namespace wind_figures_test {

void expect_whole(const WindFigures& of) {
  EXPECT_LE(of.gap_99, 0.02) << "of a leaf's length";
  EXPECT_LE(of.volume_max, 0.03);
  EXPECT_LE(of.squeeze_max, 0.1);
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

}  // namespace wind_figures_test
}  // namespace coppice::test
