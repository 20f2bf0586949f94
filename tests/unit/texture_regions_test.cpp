#include "texture_regions.h"

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <tuple>

#include "polygons.h"
#include "texture_mips.h"

namespace coppice::bake::texture_regions_test {

using Rgb = std::array<int, 3>;
constexpr Rgb kWhite{255, 255, 255}, kGreen{0, 128, 0}, kBrown{96, 64, 32};

Rgb texel(const Image& image, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* rgba = image.rgba.data() + 4 * (std::size_t{y} * image.width + x);
  return {rgba[0], rgba[1], rgba[2]};
}

/// White paper with a green disc of 22 texels' radius in the left half; the right half is bark.
Image paper_and_bark() {
  Image image{128, 64, {}};
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      const float dx = static_cast<float>(x) + 0.5f - 32.0f, dy = static_cast<float>(y) + 0.5f - 32.0f;
      const Rgb color = x >= 64 ? kBrown : dx * dx + dy * dy < 22.0f * 22.0f ? kGreen : kWhite;
      for (const int channel : color) image.rgba.push_back(static_cast<std::uint8_t>(channel));
      image.rgba.push_back(255);
    }
  return image;
}

void add_triangle(Mesh& mesh, std::uint32_t material, const std::array<glm::vec2, 3>& uvs) {
  test::add_polygon(mesh, std::array{glm::vec3(uvs[0], 0.0f), glm::vec3(uvs[1], 0.0f), glm::vec3(uvs[2], 0.0f)}, uvs, material);
}

/// A leaf inside the disc, two periods off, and bark that repeats along v.
Plant leaf_and_trunk() {
  Plant plant;
  plant.materials = {{.name = "leaf", .image = 0}, {.name = "bark", .image = 0}};
  plant.images = {paper_and_bark()};
  add_triangle(plant.foliage, 0, {glm::vec2(2.1875f, 0.375f), glm::vec2(2.3125f, 0.375f), glm::vec2(2.25f, 0.6875f)});
  plant.leaves = {{0, 1}};
  add_triangle(plant.wood, 1, {glm::vec2(0.53125f, 0.0f), glm::vec2(0.96875f, 0.0f), glm::vec2(0.96875f, 7.0f)});
  return plant;
}

/// What a texture coordinate shows: the nearest texel, repeating.
Rgb shown(const Plant& plant, std::uint32_t material, const glm::vec2& uv) {
  const Image& image = plant.images[plant.materials[material].image];
  const glm::vec2 unit = uv - glm::floor(uv);
  return texel(image, std::min(static_cast<std::uint32_t>(unit.x * static_cast<float>(image.width)), image.width - 1),
               std::min(static_cast<std::uint32_t>(unit.y * static_cast<float>(image.height)), image.height - 1));
}

TEST(TextureRegions, EachMaterialShowsWhatItDidFromAnImageOfItsOwn) {
  const Plant before = leaf_and_trunk();
  Plant after = before;
  cut_texture_regions(after);
  ASSERT_NE(after.materials[0].image, after.materials[1].image);
  const Image& leaf = after.images[after.materials[0].image];
  const Image& bark = after.images[after.materials[1].image];
  EXPECT_LE(leaf.width, 18u) << "16 texels and the filter's margin";
  EXPECT_LE(leaf.height, 22u);
  EXPECT_EQ(bark.width, 58u);
  EXPECT_EQ(bark.height, 64u) << "it repeats: all of it is shown";
  for (const auto& [mesh, was, material] : {std::tuple{&after.foliage, &before.foliage, 0u}, std::tuple{&after.wood, &before.wood, 1u}})
    for (int i = 1; i < 9; ++i)
      for (int j = 1; j + i < 10; ++j) {
        const auto inside = [&](const Mesh& of) {
          const float s = static_cast<float>(i) / 10.0f, t = static_cast<float>(j) / 10.0f;
          return of.uvs[0] * (1.0f - s - t) + of.uvs[1] * s + of.uvs[2] * t;
        };
        EXPECT_EQ(shown(after, material, inside(*mesh)), shown(before, material, inside(*was))) << material << " " << i << " " << j;
      }
}

TEST(TextureRegions, WhatNothingShowsTakesTheColoursBesideIt) {
  Plant plant = leaf_and_trunk();
  // As large as the disc: the square around it has paper in its corners.
  plant.foliage = {};
  const auto corner = [](float x, float y) { return glm::vec2(x / 128.0f, y / 64.0f); };
  add_triangle(plant.foliage, 0, {corner(32, 12.5f), corner(49, 41), corner(15, 41)});
  cut_texture_regions(plant);
  const Image leaf = mip_levels(plant.images[plant.materials[0].image], 0.0f).front();
  for (std::uint32_t y = 0; y < leaf.height; ++y)
    for (std::uint32_t x = 0; x < leaf.width; ++x) EXPECT_EQ(texel(leaf, x, y), kGreen) << x << " " << y;
}

TEST(TextureRegions, AnImageThatIsShownWholeOrHasHolesStaysAsItIs) {
  Plant plant = leaf_and_trunk();
  plant.materials[0].image = plant.materials[1].image = 0;
  plant.foliage = {};
  add_triangle(plant.foliage, 0, {glm::vec2(-3.0f, -3.0f), glm::vec2(4.0f, -3.0f), glm::vec2(0.0f, 4.0f)});
  plant.wood = {};
  const Plant whole = plant;
  cut_texture_regions(plant);
  EXPECT_EQ(plant.materials[0].image, 0u);
  EXPECT_EQ(plant.images[0].rgba, whole.images[0].rgba);
  EXPECT_EQ(plant.foliage.uvs, whole.foliage.uvs);

  Plant masked = leaf_and_trunk();
  masked.materials[0].alpha_cutoff = 0.5f;
  masked.wood = {};
  masked.images[0].rgba[3] = 0;
  add_triangle(masked.foliage, 0, {glm::vec2(0.0f, 0.0f), glm::vec2(0.99f, 0.0f), glm::vec2(0.0f, 0.99f)});
  const Plant holes = masked;
  cut_texture_regions(masked);
  EXPECT_EQ(masked.images[masked.materials[0].image].rgba, holes.images[0].rgba);
}

TEST(TextureRegions, AVertexSharedByTwoMaterialsIsSplit) {
  Plant plant = leaf_and_trunk();
  Mesh& wood = plant.wood;
  // A leaf-coloured triangle on the bark's vertices.
  wood.uvs = {glm::vec2(0.2f, 0.4f), glm::vec2(0.3f, 0.4f), glm::vec2(0.3f, 0.6f)};
  wood.indices = {0, 1, 2, 0, 1, 2};
  wood.triangle_materials = {0, 1};
  plant.foliage = {};
  add_triangle(plant.foliage, 1, {glm::vec2(0.21f, 0.41f), glm::vec2(0.22f, 0.41f), glm::vec2(0.22f, 0.42f)});
  add_triangle(plant.foliage, 0, {glm::vec2(0.1f, 0.1f), glm::vec2(0.12f, 0.1f), glm::vec2(0.12f, 0.12f)});
  cut_texture_regions(plant);
  ASSERT_EQ(wood.positions.size(), 6u);
  ASSERT_EQ(wood.uvs.size(), 6u);
  ASSERT_EQ(wood.normals.size(), 6u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(wood.positions[wood.indices[k]], wood.positions[wood.indices[3 + k]]);
    EXPECT_NE(wood.uvs[wood.indices[k]], wood.uvs[wood.indices[3 + k]]) << "the two regions differ";
  }
}

TEST(TextureRegions, NormalMapsAreCutAlike) {
  Plant plant = leaf_and_trunk();
  Image bumps{64, 32, std::vector<std::uint8_t>(std::size_t{4} * 64 * 32, 128), true};
  plant.images.push_back(bumps);
  plant.materials[1].normal_map = 1;
  // Texels 66 to 126 of 128, with the margin: 33 to 63 of 64.
  plant.wood = {};
  add_triangle(plant.wood, 1, {glm::vec2(67.0f / 128, 0.0f), glm::vec2(125.0f / 128, 0.0f), glm::vec2(125.0f / 128, 7.0f)});
  Plant odd = plant;
  cut_texture_regions(plant);
  EXPECT_EQ(plant.images[plant.materials[1].image].width, 60u);
  EXPECT_EQ(plant.images[plant.materials[1].normal_map].width, 30u);
  EXPECT_TRUE(plant.images[plant.materials[1].normal_map].is_normal_map);

  odd.wood = {};  // texels 65 to 126: with one more they are whole texels of the other
  add_triangle(odd.wood, 1, {glm::vec2(66.0f / 128, 0.0f), glm::vec2(125.0f / 128, 0.0f), glm::vec2(125.0f / 128, 7.0f)});
  cut_texture_regions(odd);
  EXPECT_EQ(odd.images[odd.materials[1].image].width, 62u);
  EXPECT_EQ(odd.images[odd.materials[1].normal_map].width, 31u);
}

TEST(TextureRegions, MaterialsThatShowOtherColoursOfOneImageShareNone) {
  Plant plant = leaf_and_trunk();
  // Both reach from corner to corner of the image.
  plant.foliage = {};
  const auto corner = [](float x, float y) { return glm::vec2(x / 128.0f, y / 64.0f); };
  for (const float x : {0.5f, 60.5f}) {
    add_triangle(plant.foliage, 0, {corner(x, 0.5f), corner(x + 2, 0.5f), corner(x, 2)});
    add_triangle(plant.foliage, 0, {corner(x, 63.5f), corner(x + 2, 63.5f), corner(x, 62)});
    add_triangle(plant.foliage, 0, {corner(127 - x, 63.5f), corner(127 - x + 0.5f, 63.5f), corner(127 - x, 63)});
  }
  plant.wood = {};
  add_triangle(plant.wood, 1, {corner(0.5f, 31), corner(127.5f, 32), corner(127.5f, 31)});
  add_triangle(plant.wood, 1, {corner(100, 0.5f), corner(101, 0.5f), corner(100, 63.5f)});
  cut_texture_regions(plant);
  EXPECT_NE(plant.materials[0].image, plant.materials[1].image);
  for (const std::uint32_t material : {0u, 1u}) {
    const Image& image = plant.images[plant.materials[material].image];
    EXPECT_EQ(image.shown.size(), std::size_t{image.width} * image.height);
    EXPECT_GT(std::ranges::count(image.shown, 0.0f), 4000) << "what only the other shows is not shown";
  }
}

}  // namespace coppice::bake::texture_regions_test
