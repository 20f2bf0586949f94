#include "error_table.h"
#include "error_image.h"

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>

#include "bounds.h"
#include "progress.h"
#include "tree_order.h"
#include "visibility.h"

namespace coppice::bake {
namespace error_table_test {

Quad square_at(const glm::vec3& center, float half) {
  return {center + glm::vec3(-half, -half, 0), center + glm::vec3(half, -half, 0), center + glm::vec3(half, half, 0),
          center + glm::vec3(-half, half, 0)};
}

/// Two squares far apart; the only collapse keeps the first and drops the second.
Foliage two_squares() {
  Foliage foliage;
  foliage.quads = {square_at({-4, 0, 0}, 1.0f), square_at({4, 0, 0}, 1.0f)};
  foliage.cards = {0, 0};
  foliage.card_table = {{0, {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}}};
  return foliage;
}

BakedPlant plant_of(const Foliage& foliage, const glm::vec4& color) {
  CollapseSequence sequence;
  sequence.merges = {{0, 1, {0, 1, 2, 3}}};
  BakedPlant plant;
  plant.tree = build_tree(foliage, sequence);
  plant.card_table = foliage.card_table;
  plant.materials = {{.name = "leaves", .base_color = color}};
  plant.sphere = plant_sphere(foliage, {});
  return plant;
}

const ProgressFunction kNoProgress = [](double) {};

TEST(ErrorTable, ErrorIsTheSideOfTheSquareOfWrongPixels) {
  // A black leaf on white: a missing one is as wrong as a pixel can be, so E(1, 512)^2 is its mean area in pixels.
  const Foliage foliage = two_squares();
  const auto table = measure_error_table(plant_of(foliage, {0, 0, 0, 1}), kNoProgress);
  ASSERT_TRUE(table) << table.error().message();
  ASSERT_EQ(table->leaf_counts, (std::vector<std::uint32_t>{1, 2}));
  ASSERT_EQ(table->sizes_px.back(), 512.0f);

  const auto buffers = render_item_buffers({foliage, {{}}, {}}, error_viewpoints(), 512);
  ASSERT_TRUE(buffers) << buffers.error().message();
  const std::vector<std::uint32_t> areas = leaf_areas_px(*buffers);
  double mean_area = 0.0;
  for (std::size_t view = 0; view < 6; ++view) mean_area += areas[view * 2 + 1] / 6.0;
  ASSERT_GT(mean_area, 100.0);
  EXPECT_NEAR(table->error_px[table->sizes_px.size() - 1], std::sqrt(mean_area), 0.01);
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
  BakedPlant plant = plant_of(two_squares(), {0.2f, 0.4f, 0.1f, 1});
  plant.tree = build_tree(foliage, sequence);
  plant.sphere = plant_sphere(foliage, {});

  const auto table = measure_error_table(plant, kNoProgress);
  ASSERT_TRUE(table) << table.error().message();
  const std::size_t sizes = table->sizes_px.size(), levels = table->leaf_counts.size();
  EXPECT_EQ(table->leaf_counts.front(), 1u);
  EXPECT_EQ(table->leaf_counts.back(), 64u);
  for (std::size_t size = 0; size < sizes; ++size) {
    EXPECT_EQ(table->error_px[(levels - 1) * sizes + size], 0.0f);
    EXPECT_GT(table->error_px[size], 0.0f);
    for (std::size_t level = 1; level < levels; ++level)
      EXPECT_LE(table->error_px[level * sizes + size], table->error_px[(level - 1) * sizes + size]);
  }
}

TEST(ErrorTable, HolesOfTheAlphaMaskAreNoError) {
  const Foliage foliage = two_squares();
  BakedPlant plant = plant_of(foliage, {1, 1, 1, 1});
  plant.images = {{1, 1, {0, 0, 0, 0}}};  // nothing but a hole
  plant.materials[0].image = 0;
  plant.materials[0].alpha_cutoff = 0.5f;
  const auto table = measure_error_table(plant, kNoProgress);
  ASSERT_TRUE(table) << table.error().message();
  for (const float error : table->error_px) EXPECT_EQ(error, 0.0f);
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

}  // namespace error_table_test
}  // namespace coppice::bake
