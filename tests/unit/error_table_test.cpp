// How wrong coarser leaves and wood look: the tables of a baked plant.

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "error_image.h"
#include "error_table.h"
#include "item_areas.h"
#include "mesh_error.h"
#include "polygons.h"
#include "progress.h"
#include "random_tree.h"
#include "results.h"
#include "test_foliage.h"
#include "tree_order.h"
#include "visibility.h"

namespace coppice::bake::error_table_test {

Quad square_at(const glm::vec3& center, float half) {
  return test::rectangle(center - glm::vec3(half, half, 0), {2 * half, 0, 0}, {0, 2 * half, 0});
}

/// Two squares far apart; the only collapse keeps the first and drops the second.
Foliage two_squares() {
  return test::plain_foliage({square_at({-4, 0, 0}, 1.0f), square_at({4, 0, 0}, 1.0f)});
}

const CollapseSequence kFirstStays{.merges = {{0, 1, {0, 1, 2, 3}}}};

BakedPlant plant_of(const Foliage& foliage, const glm::vec4& color, const CollapseSequence& sequence = kFirstStays) {
  BakedPlant plant;
  plant.tree = build_tree(foliage, sequence);
  plant.card_table = foliage.card_table;
  plant.materials = {{.name = "leaves", .base_color = color}};
  plant.sphere = plant_sphere(foliage, {});
  return plant;
}

const ProgressFunction kNoProgress = [](double) {};

TEST(ErrorTable, ErrorIsTheSideOfTheSquareOfWrongPixels) {
  // A black leaf before a dark, a leaf-coloured and a white ground: in the mean it differs from them by 110, and coverage counts 107 more,
  // of the 180 that make a pixel wrong. So E(1, 512)^2 is that share of the missing leaf's mean area in pixels.
  const Foliage foliage = two_squares();
  const auto table = test::must(measure_error_table(plant_of(foliage, {0, 0, 0, 1}), kNoProgress));
  ASSERT_EQ(table.leaf_counts, (std::vector<std::uint32_t>{1, 2}));
  ASSERT_EQ(table.sizes_px.back(), 512.0f);

  const auto buffers = test::must(render_item_buffers({foliage, {{}}, {}}, error_viewpoints(), 512));
  const std::vector<std::uint32_t> areas = leaf_areas_px(buffers);
  double mean_area = 0.0;
  for (std::size_t view = 0; view < 6; ++view) mean_area += areas[view * 2 + 1] / 6.0;
  ASSERT_GT(mean_area, 100.0);
  EXPECT_NEAR(table.error_px[table.sizes_px.size() - 1], std::sqrt(mean_area) * std::hypot(110.0, 107.0) / 180.0, 0.01);
}

TEST(ErrorTable, SeesTheLightOfNodes) {
  // Two leaves in one place become one that looks the same, but for what its normals say.
  Foliage foliage = test::plain_foliage({square_at({0, 0, 0}, 1.0f), square_at({0, 0, 0}, 1.0f)});
  const auto error_of = [&](const glm::dvec3& normal) {
    foliage.normal_sums = {quad_normal_sum(foliage.quads[0]), normal_sum(normal, 4.0)};
    return test::must(measure_error_table(plant_of(foliage, {0.2f, 0.2f, 0.2f, 1}), kNoProgress)).error_px.front();
  };
  const float same = error_of({0, 0, 1}), other = error_of({0, 1, 0});
  EXPECT_LT(same, 0.05f) << "rounding alone";
  EXPECT_GT(other, 10.0f * same);
}

TEST(ErrorTable, WholePlantHasNoErrorAndErrorNeverGrowsWithLeaves) {
  Foliage foliage;
  CollapseSequence sequence;
  for (std::uint32_t leaf = 0; leaf < 64; ++leaf) {
    const float angle = static_cast<float>(leaf) * 2.4f;
    foliage.quads.push_back(square_at({std::cos(angle) * 3, static_cast<float>(leaf) * 0.1f, std::sin(angle) * 3}, 0.4f));
    foliage.cards.push_back(0);
  }
  foliage.card_table = two_squares().card_table;
  // Leaf by leaf into one that keeps the first's corners: 0+1 -> 64, 64+2 -> ...
  for (std::uint32_t merge = 0; merge < 63; ++merge)
    sequence.merges.push_back(merge == 0 ? Merge{0, 1, {0, 1, 2, 3}} : Merge{merge + 1, merge + 63, {4, 5, 6, 7}});
  const auto table = test::must(measure_error_table(plant_of(foliage, {0.2f, 0.4f, 0.1f, 1}, sequence), kNoProgress));
  const std::size_t sizes = table.sizes_px.size(), levels = table.leaf_counts.size();
  EXPECT_EQ(table.leaf_counts.front(), 1u);
  EXPECT_EQ(table.leaf_counts.back(), 64u);
  for (std::size_t size = 0; size < sizes; ++size) {
    EXPECT_EQ(table.error_px[(levels - 1) * sizes + size], 0.0f);
    EXPECT_GT(table.error_px[size], 0.0f);
    for (std::size_t level = 1; level < levels; ++level)
      EXPECT_LE(table.error_px[level * sizes + size], table.error_px[(level - 1) * sizes + size]);
  }
}

TEST(ErrorTable, HolesOfTheAlphaMaskAreNoError) {
  const Foliage foliage = two_squares();
  BakedPlant plant = plant_of(foliage, {1, 1, 1, 1});
  plant.images = {{1, 1, {0, 0, 0, 0}}};  // nothing but a hole
  plant.materials[0].image = 0;
  plant.materials[0].alpha_cutoff = 0.5f;
  const auto table = test::must(measure_error_table(plant, kNoProgress));
  for (const float error : table.error_px) EXPECT_EQ(error, 0.0f);
}

/// Layers along z: black, white, a wide white one, white, black. At each place but the middle two leaves lie, which the first collapses
/// make one: half opaque where they are black, white_opacity / kOpaque where they are white.
BakedPlant five_layers(std::uint8_t white_opacity) {
  constexpr std::array<float, 9> kDepths{2, 2, 1, 1, 0, -1, -1, -2, -2};
  Foliage foliage;
  for (const float z : kDepths) {
    foliage.quads.push_back(square_at({0, 0, z}, z == 0.0f ? 12.0f : 2.0f));
    foliage.cards.push_back(std::abs(z) == 2.0f ? 1 : 0);
  }
  foliage.card_table = {two_squares().card_table[0], two_squares().card_table[0]};
  foliage.card_table[1].material = 1;
  CollapseSequence sequence;
  for (const std::uint32_t first : {2u, 5u}) sequence.merges.push_back({first, first + 1, {0, 1, 2, 3}, white_opacity});
  for (const std::uint32_t first : {0u, 7u}) sequence.merges.push_back({first, first + 1, {0, 1, 2, 3}, kOpaque / 2});
  sequence.merges.push_back({4, 9, {0, 1, 2, 3}});
  for (const std::uint32_t node : {10u, 11u, 12u}) sequence.merges.push_back({node, node + 3, {0, 1, 2, 3}});
  BakedPlant plant = plant_of(foliage, {1, 1, 1, 1}, sequence);
  plant.materials.push_back({.name = "black", .base_color = {0, 0, 0, 1}});
  return plant;
}

TEST(ErrorTable, WhatLiesInFrontIsBlendedOverWhatLiesBehind) {
  // White over white shows the same whether it lets light pass or not: only what is blended before black could tell.
  const auto half = measure_error_table(five_layers(kOpaque / 2), kNoProgress);
  const auto none = measure_error_table(five_layers(kOpaque), kNoProgress);
  ASSERT_TRUE(half && none);
  const auto level = static_cast<std::size_t>(std::ranges::find(half->leaf_counts, 5u) - half->leaf_counts.begin());
  ASSERT_LT(level, half->leaf_counts.size());
  for (std::size_t size = 0; size < half->sizes_px.size(); ++size) {
    const std::size_t at = level * half->sizes_px.size() + size;
    EXPECT_GT(none->error_px[at], 0.1f);
    EXPECT_NEAR(half->error_px[at], none->error_px[at], 0.01f * none->error_px[at]) << half->sizes_px[size] << " px";
  }
}

TEST(ErrorTable, IsMeasuredFromViewsThatNoCollapseUses) {
  for (std::uint32_t count = 1; count <= 128; ++count)
    for (const Viewpoint& used : *viewpoints(count))
      for (const Viewpoint& measured : error_viewpoints())
        ASSERT_LT(glm::dot(used.direction, measured.direction), 0.999999f) << count << " views: within a twelfth of a degree";
}

TEST(PlantSphere, HoldsLeavesAndWood) {
  Mesh wood;
  wood.positions = {{0, -10, 0}};
  const Sphere sphere = plant_sphere(two_squares(), wood);
  EXPECT_EQ(sphere.center, glm::vec3(0, -4.5f, 0));
  EXPECT_NEAR(sphere.radius, std::sqrt(5.0f * 5.0f + 5.5f * 5.5f), 1e-5f);
}

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

TEST(WoodError, ATrunkThatBecomesASpikeCounts) {
  // Below a leaf that is most of the picture, a trunk of 2 px at 64 px.
  BakedPlant plant = plant_of_wood();
  plant.tree.vertices = {{-0.7f, -0.3f, 0}, {0.7f, -0.3f, 0}, {0.7f, 0.7f, 0}, {-0.7f, 0.7f, 0}};
  plant.tree.nodes[0].vertices = {0, 1, 2, 3};
  Mesh trunk, spike, aside;
  test::add_polygon(trunk, test::rectangle({-0.03f, -0.95f, 0}, {0.06f, 0, 0}, {0, 0.65f, 0}));
  test::add_polygon(aside, test::rectangle({-0.025f, -0.95f, 0}, {0.06f, 0, 0}, {0, 0.65f, 0}));
  test::add_polygon(spike, std::array{glm::vec3(0, -0.95f, 0), glm::vec3(0.03f, -0.3f, 0), glm::vec3(-0.03f, -0.3f, 0)});
  const auto error_px = test::must(measure_wood_error(plant, std::array<const Mesh*, 2>{&trunk, &spike}));
  const std::size_t sizes = kErrorSizesPx.size(), at_64_px = 3, at_16_px = 1;
  EXPECT_GT(error_px[sizes + at_64_px], 4.0f) << "over two thresholds of 2 px";
  EXPECT_LT(error_px[sizes + at_16_px], 2.0f) << "a trunk of half a pixel";
  const auto moved = test::must(measure_wood_error(plant, std::array<const Mesh*, 2>{&trunk, &aside}));
  EXPECT_LT(moved[sizes + at_64_px], 1.0f) << "by a sixth of a pixel";
}

TEST(WoodError, OtherSizesAreRefused) {
  BakedPlant plant = plant_of_wood();
  plant.errors.sizes_px = {10.0f};
  const Mesh one = squares(1, 0.2f);
  EXPECT_FALSE(measure_wood_error(plant, std::array{&one}));
}

}  // namespace coppice::bake::error_table_test
