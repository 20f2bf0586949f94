// Plants scattered over a square by density maps and a seed.
#include "scene_scatter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "results.h"

namespace coppice::bake::scene_scatter_test {

bool same(const ScenePlant& a, const ScenePlant& b) {
  return a.position_m == b.position_m && a.scale == b.scale && a.species == b.species && a.tint == b.tint && a.yaw == b.yaw &&
         a.mirrored == b.mirrored;
}

TEST(Scatter, GivesExactlyTheCountInsideTheSquareAndIsAFunctionOfItsSeed) {
  const std::vector<ScatterSpecies> species = {{2.0f, nullptr}, {4.0f, nullptr}};
  const auto a = test::must(scatter_plants(species, {.seed = 3, .size_m = 800, .count = 12345}));
  EXPECT_EQ(a.size(), 12345u);
  for (const ScenePlant& plant : a) {
    EXPECT_LE(std::abs(plant.position_m[0]), 400.0f);
    EXPECT_LE(std::abs(plant.position_m[2]), 400.0f);
    EXPECT_EQ(plant.position_m[1], 0.0f);
    EXPECT_GE(plant.scale, 0.75f);
    EXPECT_LE(plant.scale, 1.25f);
  }
  for (std::uint16_t s = 0; s < 2; ++s) EXPECT_GT(std::ranges::count(a, s, &ScenePlant::species), 2000) << s;
  EXPECT_TRUE(std::ranges::equal(a, *scatter_plants(species, {.seed = 3, .size_m = 800, .count = 12345}), same));
  EXPECT_FALSE(std::ranges::equal(a, *scatter_plants(species, {.seed = 4, .size_m = 800, .count = 12345}), same));
}

TEST(Scatter, KeepsItsSpacing) {
  const std::vector<ScatterSpecies> species = {{1.0f, nullptr}, {5.0f, nullptr}};
  const auto plants = test::must(scatter_plants(species, {.size_m = 120, .count = 1500, .spacing = 0.4f}));
  for (std::size_t i = 0; i < plants.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const ScenePlant &a = plants[i], &b = plants[j];
      const float crowns_m = 0.62f * (a.scale * species[a.species].sphere_radius_m + b.scale * species[b.species].sphere_radius_m);
      EXPECT_GE(std::hypot(a.position_m[0] - b.position_m[0], a.position_m[2] - b.position_m[2]), 0.399f * crowns_m) << i << " " << j;
    }
}

TEST(Scatter, FollowsItsMaps) {
  // West white, east black; and a map of one row of a quarter, whose north is the -z half.
  const DensityMap west{2, 1, {255, 0}}, north{1, 2, {255, 51}};
  const std::vector<ScatterSpecies> species = {{1.0f, &west}, {1.0f, &north}};
  const auto plants = test::must(scatter_plants(species, {.size_m = 1000, .count = 20000, .spacing = 0.0f}));
  std::size_t in_north = 0, of_north = 0;
  for (const ScenePlant& plant : plants) {
    if (plant.species == 0) {
      EXPECT_LE(plant.position_m[0], 0.0f);
    } else {
      ++of_north;
      if (plant.position_m[2] < 0.0f) ++in_north;
    }
  }
  EXPECT_NEAR(static_cast<double>(in_north) / static_cast<double>(of_north), 5.0 / 6.0, 0.05) << "five to one, but for the groves";
}

TEST(Scatter, WideCrownsGetTheirShare) {
  // Equal maps, crowns of 6 m and 1 m: small plants must not take all of the room.
  const DensityMap white{1, 1, {255}}, half{2, 1, {255, 0}};
  std::vector<ScatterSpecies> species = {{1.6f, &white}, {9.7f, &white}};
  const auto equal = test::must(scatter_plants(species, {.size_m = 1000, .count = 16000}));
  EXPECT_EQ(std::ranges::count(equal, 0, &ScenePlant::species), 8000);
  EXPECT_EQ(std::ranges::count(equal, 1, &ScenePlant::species), 8000);
  species[1].density = &half;
  EXPECT_EQ(scatter_shares(species, 900), (std::vector<std::uint64_t>{600, 300}));
}

TEST(Scatter, OthersStandForWhatHasNoRoom) {
  const std::vector<ScatterSpecies> species = {{1.0f, nullptr}, {40.0f, nullptr}};
  const auto plants = test::must(scatter_plants(species, {.size_m = 400, .count = 1000, .spacing = 0.5f}));
  EXPECT_EQ(plants.size(), 1000u);
  const auto wide = std::ranges::count(plants, 1, &ScenePlant::species);
  EXPECT_GT(wide, 20);
  EXPECT_LT(wide, 500);
}

TEST(Scatter, SaysWhenTheyDoNotFit) {
  const std::vector<ScatterSpecies> species = {{10.0f, nullptr, "oak"}};
  test::expect_error(scatter_plants(species, {.size_m = 50, .count = 1000, .spacing = 1.0f}), Status::invalid_argument,
                     {"1000", "oak", "12.4", "1", "50"});
  const DensityMap black{1, 1, {0}};
  test::expect_error(scatter_plants(std::vector<ScatterSpecies>{{1.0f, &black}}, {.size_m = 50, .count = 10}), Status::invalid_argument,
                     {"black"});
  EXPECT_FALSE(scatter_plants(species, {.size_m = 50, .count = 0}));
  EXPECT_FALSE(scatter_plants({}, {.size_m = 50, .count = 10}));
}

}  // namespace coppice::bake::scene_scatter_test
