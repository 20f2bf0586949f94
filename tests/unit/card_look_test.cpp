// What a card shows from afar.

#include "card_look.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>

#include "reader.h"

namespace coppice::bake::card_look_test {

using Rgba = std::array<std::uint8_t, 4>;

constexpr Rgba kGreen{0, 188, 0, 255}, kHole{255, 0, 0, 0};

/// A TEXTURE chunk of `side` x `side` texels.
template <class TexelAt>
std::vector<std::uint8_t> texture_chunk(std::uint32_t side, TexelAt&& texel_at) {
  const coppice_file_texture header{side, side, 1, COPPICE_TEXTURE_RGBA8};
  std::vector<std::uint8_t> chunk(sizeof header);
  std::memcpy(chunk.data(), &header, sizeof header);
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) {
      const Rgba texel = texel_at(x, y);
      chunk.insert(chunk.end(), texel.begin(), texel.end());
    }
  return chunk;
}

std::vector<std::uint8_t> quarters_chunk(const std::array<Rgba, 4>& quarters) {
  return texture_chunk(8, [&](std::size_t x, std::size_t y) { return quarters[y / 4 * 2 + x / 4]; });
}

coppice_file_material material_of(std::uint32_t texture) {
  coppice_file_material material{.base_color = {1.0f, 1.0f, 1.0f, 1.0f}, .alpha_cutoff = 0.5f};
  set_material_textures(material, texture, COPPICE_NO_TEXTURE);
  return material;
}

/// A card that shows all of the picture.
coppice_file_card look_of(const coppice_file_material& material, const std::vector<std::vector<std::uint8_t>>& textures,
                          const ShownShares& shown = kAllShown) {
  coppice_file_card card{.material = 0, .uv = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  set_card_look(material, textures, shown, card);
  return card;
}

TEST(CardLook, HolesHaveNoColourAndNoCells) {
  const coppice_file_card card =
      look_of(material_of(1), {quarters_chunk({kGreen, kGreen, kGreen, kGreen}), quarters_chunk({kGreen, kHole, kHole, kHole})});
  // Texels between green and a hole have some of its red.
  EXPECT_LT(card.albedo[0], 110);
  EXPECT_NEAR(card.albedo[1], 188, 14);
  EXPECT_EQ(card.albedo[2], 0);
  EXPECT_NEAR(std::popcount(card.mask[0]) + std::popcount(card.mask[1]), 16, 4);
  EXPECT_EQ(card.mask[0] & 0x0f0f0f0fu, 0x0f0f0f0fu) << "the quarter at corner 0";
}

TEST(CardLook, BaseColourMultipliesAndACardShowsItsPart) {
  coppice_file_material material = material_of(0);
  material.base_color[1] = 0.5f;
  coppice_file_card card{.material = 0, .uv = {{0.1f, 0.1f}, {0.4f, 0.1f}, {0.4f, 0.4f}, {0.1f, 0.4f}}};
  set_card_look(material, std::vector(1, quarters_chunk({kGreen, kHole, kHole, kHole})), kAllShown, card);
  EXPECT_NEAR(card.albedo[1], 137, 2) << "sRGB of half of linear 0.503";
  EXPECT_EQ(card.mask[0] & card.mask[1], 0xffffffffu);
}

TEST(CardLook, WhatIsHiddenDoesNotColourIt) {
  constexpr Rgba kDark{0, 60, 0, 255};
  const auto texture = quarters_chunk({kDark, kGreen, kDark, kGreen});
  const coppice_file_card open = look_of(material_of(0), {texture}), hidden = look_of(material_of(0), {texture}, {0, 0, 0, 0, 1, 1, 1, 1});
  EXPECT_LT(open.albedo[1], 150);
  EXPECT_GT(hidden.albedo[1], 180);
  EXPECT_EQ(open.mask[0], hidden.mask[0]);
}

TEST(CardLook, PartsThinnerThanACellKeepTheirShare) {
  // A crown on a stem: half of the card, and a sixteenth of the other half.
  const auto texel_at = [](std::size_t x, std::size_t y) { return y < 32 || (x >= 30 && x < 34) ? kGreen : kHole; };
  const coppice_file_card card = look_of(material_of(0), {texture_chunk(64, texel_at)});
  EXPECT_EQ(card.mask[0], 0xffffffffu);
  EXPECT_NEAR(std::popcount(card.mask[1]), 2, 1);
  EXPECT_EQ(card.mask[1] & ~0x18181818u, 0u) << "the columns of the stem";
}

TEST(CardLook, WithoutATextureItIsAllBaseColourAndWhatIsAllHoleKeepsACell) {
  coppice_file_material bare = material_of(COPPICE_NO_TEXTURE);
  bare.base_color[2] = 0.0f;
  const coppice_file_card solid = look_of(bare, {}), hole = look_of(material_of(0), {quarters_chunk({kHole, kHole, kHole, kHole})});
  EXPECT_EQ(solid.albedo[0], 255);
  EXPECT_EQ(solid.albedo[2], 0);
  EXPECT_EQ(solid.mask[0] & solid.mask[1], 0xffffffffu);
  EXPECT_EQ(std::popcount(hole.mask[0]) + std::popcount(hole.mask[1]), 1);
}

}  // namespace coppice::bake::card_look_test
