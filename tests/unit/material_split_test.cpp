#include "material_split.h"

#include <gtest/gtest.h>
#include <glm/vec3.hpp>

#include <array>
#include <set>

#include "coppice/format.h"
#include "polygons.h"

namespace coppice::bake::material_split_test {

/// A triangle of 2 m^2 with the uvs `at` and two texels beside it in an image of 64.
void add_triangle(Mesh& mesh, const glm::vec2& at, const glm::vec3& tint = glm::vec3(1.0f)) {
  const auto z = static_cast<float>(mesh.positions.size());
  test::add_polygon(mesh, std::array{glm::vec3(0, 0, z), glm::vec3(2, 0, z), glm::vec3(0, 2, z)},
                    std::array{at, at + glm::vec2(2, 0) / 64.0f, at + glm::vec2(0, 2) / 64.0f});
  mesh.triangle_tints.push_back(tint);
}

void add_leaf(Plant& plant, const glm::vec2& at, const glm::vec3& tint = glm::vec3(1.0f)) {
  plant.leaves.push_back({static_cast<std::uint32_t>(plant.foliage.triangle_materials.size()), 1});
  add_triangle(plant.foliage, at, tint);
}

/// Columns of 8 texels: green, red, green, red, ...
Image columns() {
  Image image{64, 64, {}};
  for (std::uint32_t i = 0; i < 64 * 64; ++i) {
    if (i % 64 / 8 % 2 == 0)
      image.rgba.insert(image.rgba.end(), {30, 120, 30, 255});
    else
      image.rgba.insert(image.rgba.end(), {200, 30, 30, 255});
  }
  return image;
}

Plant empty_plant() {
  Plant plant;
  plant.materials = {{.name = "all", .base_color = {0.5f, 0.5f, 0.5f, 1.0f}, .image = 0}};
  plant.images = {columns()};
  return plant;
}

std::set<std::uint32_t> materials_of(const Mesh& mesh) {
  return {mesh.triangle_materials.begin(), mesh.triangle_materials.end()};
}

TEST(MaterialSplit, PiecesOfOneColourStayTogether) {
  Plant plant = empty_plant();
  for (const float y : {0.1f, 0.5f, 0.8f}) add_leaf(plant, {1.0f / 64.0f, y});
  add_triangle(plant.wood, {2.0f / 64.0f, 0.3f});
  split_materials(plant);
  EXPECT_EQ(plant.materials.size(), 1u);
  EXPECT_EQ(materials_of(plant.foliage), std::set<std::uint32_t>{0});
  EXPECT_TRUE(plant.foliage.triangle_tints.empty()) << "a tint counts once";
}

TEST(MaterialSplit, LeavesAndWoodOfOtherColoursAreToldApart) {
  Plant plant = empty_plant();
  add_leaf(plant, {1.0f / 64.0f, 0.1f});
  add_triangle(plant.wood, {10.0f / 64.0f, 0.1f});
  add_triangle(plant.wood, {10.0f / 64.0f, 0.3f});
  split_materials(plant);
  ASSERT_EQ(plant.materials.size(), 2u);
  EXPECT_EQ(materials_of(plant.wood).size(), 1u);
  EXPECT_NE(plant.wood.triangle_materials[0], plant.foliage.triangle_materials[0]);
  EXPECT_EQ(plant.materials[1].base_color, plant.materials[0].base_color);
  EXPECT_EQ(plant.materials[1].name, "all");
}

TEST(MaterialSplit, BarkWithLightAndDarkPlacesStaysOne) {
  // Loose triangles all over the image, some in each column: copies of the image for each colour would not pay.
  Plant plant = empty_plant();
  for (std::uint32_t i = 0; i < 32; ++i)
    add_triangle(plant.wood, {static_cast<float>(i % 8 * 8 + 2) / 64.0f, static_cast<float>(i / 8) / 5.0f});
  split_materials(plant);
  EXPECT_EQ(plant.materials.size(), 1u);
}

TEST(MaterialSplit, TintsBecomeBaseColoursOfPiecesThatDiffer) {
  Plant plant = empty_plant();
  plant.materials[0].image = kNone;
  const glm::vec3 green(0.4f, 1.6f, 0.4f), brown(1.2f, 0.6f, 0.3f), yellow(1.9f, 1.7f, 0.2f);
  for (int i = 0; i < 5; ++i) add_leaf(plant, {0.0f, 0.0f}, green);
  add_leaf(plant, {0.0f, 0.0f}, yellow);
  for (int i = 0; i < 3; ++i) add_triangle(plant.wood, {0.0f, 0.0f}, brown);
  split_materials(plant);
  ASSERT_EQ(plant.materials.size(), 3u);
  const auto expect_color = [&](std::uint32_t material, const glm::vec3& tint) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(plant.materials[material].base_color[c], 0.5f * tint[c], 1e-5f) << material;
  };
  expect_color(plant.foliage.triangle_materials[0], green);
  expect_color(plant.foliage.triangle_materials[5], yellow);
  expect_color(plant.wood.triangle_materials[2], brown);
}

TEST(MaterialSplit, NeverMoreMaterialsThanAFileHolds) {
  Plant plant = empty_plant();
  plant.materials.resize(COPPICE_MAX_MATERIALS, plant.materials[0]);
  add_leaf(plant, {1.0f / 64.0f, 0.1f});
  add_triangle(plant.wood, {10.0f / 64.0f, 0.1f});
  split_materials(plant);
  EXPECT_EQ(plant.materials.size(), std::size_t{COPPICE_MAX_MATERIALS});
}

}  // namespace coppice::bake::material_split_test
