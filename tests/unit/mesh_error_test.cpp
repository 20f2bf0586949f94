#include "mesh_error.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "error_image.h"
#include "polygons.h"
#include "random_tree.h"
#include "results.h"
#include "test_foliage.h"

namespace coppice::bake {
namespace mesh_error_test {

/// Black squares in a row, each `side` wide and facing +z.
Mesh squares(int count, float side) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const float x = static_cast<float>(i) * 2.0f * side - 0.5f;
    test::add_polygon(mesh, test::rectangle({x, 0, 0}, {side, 0, 0}, {0, side, 0}));
  }
  return mesh;
}

/// Wood of black squares and one leaf too small to be seen.
BakedPlant plant_of_wood() {
  BakedPlant plant = test::random_plant({.leaf_count = 1, .wood_lod_count = 0, .texture_side = 0});
  plant.materials[0].base_color = {0, 0, 0, 1};
  for (glm::vec3& vertex : plant.tree.vertices) vertex = glm::vec3(0.0f);
  plant.sphere = {glm::vec3(0.0f), 1.0f};
  plant.errors.sizes_px.assign(kErrorSizesPx.begin(), kErrorSizesPx.end());
  return plant;
}

TEST(WoodError, IsTheSideOfTheSquareOfPixelsThatAreMissing) {
  const BakedPlant plant = plant_of_wood();
  const Mesh all = squares(3, 0.2f), two = squares(2, 0.2f), one = squares(1, 0.2f);
  const auto error_px = test::must(measure_wood_error(plant, std::array{&all, &two, &one}));
  const std::size_t sizes = kErrorSizesPx.size(), last = sizes - 1;
  ASSERT_EQ(error_px.size(), 3 * sizes);
  for (std::size_t i = 0; i < sizes; ++i) EXPECT_EQ(error_px[i], 0.0f) << "the finest is what there is";
  double mean_area = 0.0;  // a square's, over the views
  for (const Viewpoint& view : error_viewpoints()) mean_area += std::abs(static_cast<double>(view.direction.z)) * 0.04 * 256 * 256 / 6.0;
  EXPECT_NEAR(error_px[sizes + last], std::sqrt(mean_area), 0.05 * std::sqrt(mean_area));
  EXPECT_GT(96.0 * 2.0 / 3.0, std::sqrt(2.0 * mean_area)) << "two thirds of the plant count more than their pixels";
  EXPECT_NEAR(error_px[2 * sizes + last], 96.0 * 2.0 / 3.0, 0.5);
}

TEST(WoodError, DoesNotFallTowardsCoarserLods) {
  const BakedPlant plant = plant_of_wood();
  const Mesh all = squares(3, 0.2f), one = squares(1, 0.2f);
  const auto error_px = test::must(measure_wood_error(plant, std::array{&all, &one, &all}));
  const std::size_t sizes = kErrorSizesPx.size();
  for (std::size_t i = 0; i < sizes; ++i) EXPECT_EQ(error_px[2 * sizes + i], error_px[sizes + i]);
}

TEST(WoodError, WhatLeavesHideDoesNotCount) {
  BakedPlant plant = plant_of_wood();
  const Mesh all = squares(3, 0.2f), one = squares(1, 0.2f);
  const auto bare = measure_wood_error(plant, std::array{&all, &one});
  // One leaf before all of it and one behind, seen from either side.
  plant.tree.vertices = {{-2, -2, 0.001f}, {2, -2, 0.001f}, {2, 2, 0.001f}, {-2, 2, 0.001f}};
  plant.tree.nodes[0].vertices = {0, 1, 2, 3};
  const auto hidden = measure_wood_error(plant, std::array{&all, &one});
  ASSERT_TRUE(bare && hidden);
  EXPECT_LT(hidden->back(), 0.8f * bare->back()) << "half of the views have the leaf in front";
}

TEST(WoodError, NormalsThatAreWrongCount) {
  BakedPlant plant = plant_of_wood();
  plant.materials[0].base_color = {0.2f, 0.2f, 0.2f, 1.0f};
  const Mesh whole = squares(3, 0.2f);
  Mesh turned = whole;
  for (glm::vec3& normal : turned.normals) normal = glm::vec3(0.0f, 1.0f, 0.0f);
  const auto error_px = test::must(measure_wood_error(plant, std::array<const Mesh*, 2>{&whole, &turned}));
  EXPECT_GT(error_px.back(), 3.0f) << "its triangles are where they were, but lit from another side";
}

TEST(WoodError, AThinStemThatIsMissingCounts) {
  // A square on a stem, a 200th of its height wide: of the square's picture the stem is a tenth, and none of its pixels at 64 px is dark.
  BakedPlant plant = plant_of_wood();
  Mesh whole = squares(1, 0.45f);
  Mesh without = whole;
  test::add_polygon(whole, test::rectangle({-0.005f, -0.95f, 0}, {0.01f, 0, 0}, {0, 0.95f, 0}));
  const auto error_px = test::must(measure_wood_error(plant, std::array{&whole, &without}));
  const std::size_t sizes = kErrorSizesPx.size(), at_64_px = 3;
  const double stem = 0.95 * 0.01, square = 0.45 * 0.45;
  EXPECT_NEAR(error_px[sizes + at_64_px], 96.0 * stem / (stem + square), 1.0) << "what it is of the plant counts, in all parts of it";
  EXPECT_LT(error_px[sizes], error_px[sizes + at_64_px] / 4.0) << "less where the plant is small";
}

TEST(WoodError, OtherSizesAreRefused) {
  BakedPlant plant = plant_of_wood();
  plant.errors.sizes_px = {10.0f};
  const Mesh one = squares(1, 0.2f);
  EXPECT_FALSE(measure_wood_error(plant, std::array{&one}));
}

}  // namespace mesh_error_test
}  // namespace coppice::bake
