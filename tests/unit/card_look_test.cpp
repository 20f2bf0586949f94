// What a card shows from afar.

#include "card_look.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>

#include "reader.h"

namespace coppice::bake {
namespace card_look_test {

using Rgba = std::array<std::uint8_t, 4>;

/// A TEXTURE chunk of 8 x 8 texels.
std::vector<std::uint8_t> texture_chunk(const std::array<Rgba, 4>& quarters) {
  const coppice_file_texture header{8, 8, 1, COPPICE_TEXTURE_RGBA8};
  std::vector<std::uint8_t> chunk(sizeof header);
  std::memcpy(chunk.data(), &header, sizeof header);
  for (std::size_t y = 0; y < 8; ++y)
    for (std::size_t x = 0; x < 8; ++x) {
      const Rgba& texel = quarters[y / 4 * 2 + x / 4];
      chunk.insert(chunk.end(), texel.begin(), texel.end());
    }
  return chunk;
}

coppice_file_material material_of(std::uint32_t texture) {
  coppice_file_material material{.base_color = {1.0f, 1.0f, 1.0f, 1.0f}, .alpha_cutoff = 0.5f};
  set_material_textures(material, texture, COPPICE_NO_TEXTURE);
  return material;
}

coppice_file_card whole_card() {
  return {.material = 0, .uv = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
}

constexpr Rgba kGreen{0, 188, 0, 255}, kHole{255, 0, 0, 0};

TEST(CardLook, HolesHaveNoColourAndNoCells) {
  const std::vector<std::vector<std::uint8_t>> textures{texture_chunk({kGreen, kGreen, kGreen, kGreen}),
                                                        texture_chunk({kGreen, kHole, kHole, kHole})};
  coppice_file_card card = whole_card();
  set_card_look(material_of(1), textures, kAllShown, card);
  // Texels between green and a hole have some of its red.
  EXPECT_LT(card.albedo[0], 110);
  EXPECT_NEAR(card.albedo[1], 188, 14);
  EXPECT_EQ(card.albedo[2], 0);
  EXPECT_NEAR(std::popcount(card.mask[0]) + std::popcount(card.mask[1]), 16, 4);
  EXPECT_EQ(card.mask[0] & 0x0f0f0f0fu, 0x0f0f0f0fu) << "the quarter at corner 0";
}

TEST(CardLook, BaseColourMultipliesAndACardShowsItsPart) {
  const std::vector<std::vector<std::uint8_t>> textures{texture_chunk({kGreen, kHole, kHole, kHole})};
  coppice_file_material material = material_of(0);
  material.base_color[1] = 0.5f;
  coppice_file_card card{.material = 0, .uv = {{0.1f, 0.1f}, {0.4f, 0.1f}, {0.4f, 0.4f}, {0.1f, 0.4f}}};
  set_card_look(material, textures, kAllShown, card);
  EXPECT_NEAR(card.albedo[1], 137, 2) << "sRGB of half of linear 0.503";
  EXPECT_EQ(card.mask[0] & card.mask[1], 0xffffffffu);
}

TEST(CardLook, WhatIsHiddenDoesNotColourIt) {
  constexpr Rgba kDark{0, 60, 0, 255};
  const std::vector<std::vector<std::uint8_t>> textures{texture_chunk({kDark, kGreen, kDark, kGreen})};
  coppice_file_card open = whole_card(), hidden = whole_card();
  set_card_look(material_of(0), textures, kAllShown, open);
  set_card_look(material_of(0), textures, {0, 0, 0, 0, 1, 1, 1, 1}, hidden);
  EXPECT_LT(open.albedo[1], 150);
  EXPECT_GT(hidden.albedo[1], 180);
  EXPECT_EQ(open.mask[0], hidden.mask[0]);
}

TEST(CardLook, PartsThinnerThanACellKeepTheirShare) {
  // A crown on a stem: half of the card, and a sixteenth of the other half.
  coppice_file_texture header{64, 64, 1, COPPICE_TEXTURE_RGBA8};
  std::vector<std::uint8_t> chunk(sizeof header);
  std::memcpy(chunk.data(), &header, sizeof header);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const Rgba texel = y < 32 || (x >= 30 && x < 34) ? kGreen : kHole;
      chunk.insert(chunk.end(), texel.begin(), texel.end());
    }
  const std::vector<std::vector<std::uint8_t>> textures{chunk};
  coppice_file_card card = whole_card();
  set_card_look(material_of(0), textures, kAllShown, card);
  EXPECT_EQ(card.mask[0], 0xffffffffu);
  EXPECT_NEAR(std::popcount(card.mask[1]), 2, 1);
  EXPECT_EQ(card.mask[1] & ~0x18181818u, 0u) << "the columns of the stem";
}

TEST(CardLook, WithoutATextureItIsAllBaseColour) {
  coppice_file_material material = material_of(COPPICE_NO_TEXTURE);
  material.base_color[2] = 0.0f;
  coppice_file_card card = whole_card();
  set_card_look(material, {}, kAllShown, card);
  EXPECT_EQ(card.albedo[0], 255);
  EXPECT_EQ(card.albedo[2], 0);
  EXPECT_EQ(card.mask[0] & card.mask[1], 0xffffffffu);
}

TEST(CardLook, WhatIsAllHoleKeepsACell) {
  const std::vector<std::vector<std::uint8_t>> textures{texture_chunk({kHole, kHole, kHole, kHole})};
  coppice_file_card card = whole_card();
  set_card_look(material_of(0), textures, kAllShown, card);
  EXPECT_EQ(std::popcount(card.mask[0]) + std::popcount(card.mask[1]), 1);
}

}  // namespace card_look_test
}  // namespace coppice::bake
