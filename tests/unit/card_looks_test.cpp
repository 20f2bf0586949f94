// What cards, materials and triangles show from afar, of the images that their materials name.

#include "card_looks.h"

#include <array>
#include <cstring>

#include <gtest/gtest.h>

namespace coppice::gpu {
namespace {

/// A TEXTURE chunk of 4 x 4 texels of a colour.
std::vector<std::uint8_t> texture_chunk(const std::array<std::uint8_t, 4>& rgba) {
  const coppice_file_texture header{4, 4, 1, COPPICE_TEXTURE_RGBA8};
  std::vector<std::uint8_t> chunk(sizeof header);
  std::memcpy(chunk.data(), &header, sizeof header);
  for (int i = 0; i < 16; ++i) chunk.insert(chunk.end(), rgba.begin(), rgba.end());
  return chunk;
}

/// One card of one material that shows texture `texture` of two, and leaf meshes.
PlantLooks looks_of(std::uint32_t texture, std::uint32_t normal_map) {
  PlantFile file;
  file.plant.texture_count = 2;
  file.plant.leaf_mesh_count = 1;
  file.cards.resize(1);
  coppice_file_material& material = file.materials.emplace_back();
  for (float& channel : material.base_color) channel = 1.0f;
  set_material_textures(material, texture, normal_map);
  return plain_looks(file);
}

TEST(CardLooks, AMaterialsColourIsThatOfItsTextureWhateverItsNormalMap) {
  constexpr float kLinear188 = 0.503f;
  const std::vector<std::uint8_t> green = texture_chunk({0, 188, 0, 255}), bluish = texture_chunk({128, 128, 255, 255});
  constexpr TriangleUvs kUvs{{{0, 0}, {1, 0}, {0, 1}}};
  for (const std::uint32_t texture : {0u, 1u})
    for (const std::uint32_t normal_map : {COPPICE_NO_TEXTURE, 1 - texture}) {
      PlantLooks looks = looks_of(texture, normal_map);
      EXPECT_FALSE(has_texels(looks, 0));
      EXPECT_FALSE(take_texture(looks, 1 - texture, bluish)) << "the normal map, or nobody's";
      EXPECT_FALSE(has_texels(looks, 0));
      EXPECT_TRUE(take_texture(looks, texture, green)) << "a card shows it";
      ASSERT_TRUE(has_texels(looks, 0));
      ASSERT_EQ(looks.looks.size(), 2u);
      for (const RasterCard& look : looks.looks) {
        EXPECT_NEAR(look.albedo.y, kLinear188, 0.01f);
        EXPECT_EQ(look.albedo.x, 0.0f);
      }
      EXPECT_NEAR(triangle_look(looks, 0, kUvs, 2).albedo[1], kLinear188, 0.01f);
    }
}

TEST(CardLooks, AMaterialOfANormalMapAloneHasItsBaseColour) {
  PlantLooks looks = looks_of(COPPICE_NO_TEXTURE, 0);
  EXPECT_TRUE(has_texels(looks, 0));
  EXPECT_FALSE(take_texture(looks, 0, texture_chunk({128, 128, 255, 255})));
  for (const RasterCard& look : looks.looks) EXPECT_EQ(look.albedo.x, 1.0f);
  EXPECT_EQ(triangle_look(looks, 0, {}, 2).coverage, 1.0f);
}

TEST(CardLooks, ATrianglesCoverIsThatOfEqualParts) {
  PlantLooks looks = looks_of(0, COPPICE_NO_TEXTURE);
  looks.materials[0].alpha_cutoff = 0.5f;
  // A texel is 1/16 of the width; the left three quarters are covered.
  looks.small[0] = {16, 1, {}};
  for (int x = 0; x < 16; ++x)
    looks.small[0].rgba.insert(looks.small[0].rgba.end(), {255, 255, 255, static_cast<std::uint8_t>(x < 12 ? 255 : 0)});
  // u runs from 1/16 to 15/16, so the cut is at 11/14 of it: all but (3/14)^2 of a triangle whose u falls from the right angle on.
  constexpr TriangleUvs kUvs{{{1.0f / 16, 0.5f}, {15.0f / 16, 0.5f}, {1.0f / 16, 0.5f}}};
  EXPECT_NEAR(triangle_look(looks, 0, kUvs, 16).coverage, 1.0f - 9.0f / 196.0f, 0.02f);
}

}  // namespace
}  // namespace coppice::gpu
