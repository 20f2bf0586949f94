// What materials and triangles show from afar, of the images that their materials name.

#include "card_looks.h"

#include <array>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "hook_array.h"

namespace coppice::gpu::card_looks_test {

/// A TEXTURE chunk of 4 x 4 texels of a colour.
std::vector<std::uint8_t> texture_chunk(const std::array<std::uint8_t, 4>& rgba) {
  const coppice_file_texture header{4, 4, 1, COPPICE_TEXTURE_RGBA8};
  std::vector<std::uint8_t> chunk(sizeof header);
  std::memcpy(chunk.data(), &header, sizeof header);
  for (int i = 0; i < 16; ++i) chunk.insert(chunk.end(), rgba.begin(), rgba.end());
  return chunk;
}

using Chunks = std::array<std::vector<std::uint8_t>, 2>;

/// One material, and leaf meshes. small: of both textures
PlantLooks looks_of(std::uint32_t texture, std::uint32_t normal_map, const Chunks& small, float alpha_cutoff = 0.0f) {
  PlantFile file;
  file.plant.texture_count = 2;
  file.plant.leaf_mesh_count = 1;
  file.materials = test::hook_array(std::vector<coppice_file_material>(1));
  coppice_file_material& material = file.materials[0];
  for (float& channel : material.base_color) channel = 1.0f;
  material.alpha_cutoff = alpha_cutoff;
  set_material_textures(material, texture, normal_map);
  file.small_textures = test::hook_arrays(small);
  return *plant_looks(file, default_allocator());
}

TEST(CardLooks, AMaterialsColourIsThatOfItsTextureWhateverItsNormalMap) {
  constexpr float kLinear188 = 0.503f;
  const std::vector<std::uint8_t> green = texture_chunk({0, 188, 0, 255});
  constexpr TriangleUvs kUvs{{{0, 0}, {1, 0}, {0, 1}}};
  for (const std::uint32_t texture : {0u, 1u})
    for (const std::uint32_t normal_map : {COPPICE_NO_TEXTURE, 1 - texture}) {
      Chunks small;
      small[texture] = green;
      const PlantLooks looks = looks_of(texture, normal_map, small);
      EXPECT_EQ(wood_color_of(looks, 0, kUvs), pack_albedo({0.0f, kLinear188, 0.0f}));
      EXPECT_NEAR(triangle_look(looks, 0, kUvs, 2).albedo[1], kLinear188, 0.01f);
    }
}

TEST(CardLooks, AMaterialOfANormalMapAloneHasItsBaseColour) {
  const PlantLooks looks = looks_of(COPPICE_NO_TEXTURE, 0, {});
  ASSERT_EQ(looks.wood_colors.size(), 1u);
  EXPECT_EQ(looks.wood_colors[0], pack_albedo({1.0f, 1.0f, 1.0f}));
  EXPECT_EQ(triangle_look(looks, 0, {}, 2).coverage, 1.0f);
}

/// 4 x 4 texels, of which each quarter has a colour of its own; the last is a hole.
std::vector<std::uint8_t> quarters() {
  std::vector<std::uint8_t> chunk = texture_chunk({255, 0, 0, 255});
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < 4; ++x) {
      std::uint8_t* texel = chunk.data() + sizeof(coppice_file_texture) + 4 * (4 * y + x);
      if (x >= 2) texel[1] = 255;
      if (y >= 2) texel[0] = 0;
      if (x >= 2 && y >= 2) texel[3] = 0;
    }
  return chunk;
}

TEST(CardLooks, WoodHasTheColourOfItsPartOfTheTexture) {
  const PlantLooks looks = looks_of(0, COPPICE_NO_TEXTURE, {quarters()}, 0.5f);
  const auto color = [&](float u, float v, float side) { return wood_color_of(looks, 0, {{{u, v}, {u + side, v}, {u, v + side}}}); };
  const std::uint32_t red = pack_albedo({1, 0, 0}), yellow = pack_albedo({1, 1, 0}), black = pack_albedo({0, 0, 0});
  for (const float side : {0.0f, 0.01f, 0.1f, 0.2f}) {
    EXPECT_EQ(color(0.1f, 0.1f, side), red) << side;
    EXPECT_EQ(color(0.6f, 0.1f, side), yellow) << side;
    EXPECT_EQ(color(0.1f, 0.6f, side), black) << side;
    EXPECT_EQ(color(-2.9f, 5.1f, side), red) << "textures repeat: " << side;
  }
  const std::uint32_t mean = pack_albedo({2.0f / 3, 1.0f / 3, 0});
  EXPECT_EQ(color(0.6f, 0.6f, 0.1f), mean) << "a part that is all hole shows what is round it";
  EXPECT_EQ(color(0.0f, 0.0f, 3.0f), mean) << "larger than the texture";
  wood_color_of(looks, 0, {{{NAN, 0}, {1e30f, 0}, {0, -1e30f}}});  // stays inside the table
}

TEST(CardLooks, ATrianglesCoverageIsThatOfEqualParts) {
  PlantLooks looks = looks_of(0, COPPICE_NO_TEXTURE, {texture_chunk({})}, 0.5f);
  // A texel is 1/16 of the width; the left three quarters are covered.
  std::vector<std::uint8_t> rgba(4 * 16, 255);
  for (std::size_t x = 12; x < 16; ++x) rgba[4 * x + 3] = 0;
  looks.small[0] = {16, 1, test::hook_array(rgba)};
  // u runs from 1/16 to 15/16, so the cut is at 11/14 of it: all but (3/14)^2 of a triangle whose u falls from the right angle on.
  constexpr TriangleUvs kUvs{{{1.0f / 16, 0.5f}, {15.0f / 16, 0.5f}, {1.0f / 16, 0.5f}}};
  EXPECT_NEAR(triangle_look(looks, 0, kUvs, 16).coverage, 1.0f - 9.0f / 196.0f, 0.02f);
}

}  // namespace coppice::gpu::card_looks_test
