// Textures on their way into a file: mip levels, and how they are stored.

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "block_texture.h"
#include "results.h"
#include "texture_encode.h"
#include "texture_mips.h"

namespace coppice::bake::texture_encode_test {

/// Solid discs of `colour` on transparent black, `pitch` apart.
Image discs(std::uint32_t side, std::uint32_t pitch, double radius, std::array<std::uint8_t, 3> colour) {
  Image image{side, side, {}};
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      const double dx = static_cast<double>(x % pitch) - pitch * 0.5 + 0.5, dy = static_cast<double>(y % pitch) - pitch * 0.5 + 0.5;
      const bool inside = std::hypot(dx, dy) <= radius;
      for (std::uint8_t channel : colour) image.rgba.push_back(inside ? channel : std::uint8_t{0});
      image.rgba.push_back(inside ? 255 : 0);
    }
  return image;
}

TEST(MipLevels, HalveDownToOneTexel) {
  const auto levels = mip_levels(Image{5, 3, std::vector<std::uint8_t>(60, 255)}, 0.0f);
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_EQ(levels[1].width, 2u);
  EXPECT_EQ(levels[1].height, 1u);
  EXPECT_EQ(levels[2].width, 1u);
  EXPECT_EQ(levels[2].rgba, (std::vector<std::uint8_t>{255, 255, 255, 255}));
}

TEST(MipLevels, AverageInLinearLight) {
  // Half black, half white: half the light is sRGB 188, not 128.
  const auto levels = mip_levels(Image{2, 1, {0, 0, 0, 255, 255, 255, 255, 255}}, 0.0f);
  ASSERT_EQ(levels.size(), 2u);
  EXPECT_EQ(levels[1].rgba, (std::vector<std::uint8_t>{188, 188, 188, 255}));
}

TEST(MipLevels, OddSidesLoseNoTexel) {
  const auto levels = mip_levels(Image{3, 1, {0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255}}, 0.0f);
  ASSERT_EQ(levels.size(), 2u);
  EXPECT_EQ(levels[1].rgba[0], 156);  // a third of the light
}

TEST(MipLevels, HolesTakeTheColourAroundThem) {
  for (const Image& level : mip_levels(discs(64, 16, 5.0, {40, 160, 20}), 0.5f))
    for (std::size_t i = 0; i < level.rgba.size(); i += 4) {
      ASSERT_NEAR(level.rgba[i], 40, 1);
      ASSERT_NEAR(level.rgba[i + 1], 160, 1);
      ASSERT_NEAR(level.rgba[i + 2], 20, 1);
    }
  // So does what the alpha test discards.
  for (const Image& level : mip_levels(Image{2, 1, {255, 0, 255, 100, 0, 128, 0, 200}}, 0.5f))
    for (std::size_t i = 0; i < level.rgba.size(); i += 4) EXPECT_EQ(level.rgba[i + 1], 128);
}

TEST(MipLevels, WhatIsNotShownDoesNotCount) {
  // Green and brown that are shown, three and one times; the rest is paper.
  Image image{4, 1, {0, 200, 0, 255, 250, 250, 250, 255, 250, 250, 250, 0, 100, 50, 0, 255}};
  image.shown = {3.0f, 0.0f, 0.0f, 1.0f};
  for (const float cutoff : {0.0f, 0.5f}) {
    const auto levels = mip_levels(image, cutoff);
    ASSERT_EQ(levels.size(), 3u);
    EXPECT_EQ(levels[1].rgba, (std::vector<std::uint8_t>{0, 200, 0, 255, 100, 50, 0, 255})) << cutoff;
    EXPECT_EQ(levels[0].rgba, (std::vector<std::uint8_t>{0, 200, 0, 255, 0, 200, 0, 255, 100, 50, 0, 255, 100, 50, 0, 255})) << cutoff;
    EXPECT_NEAR(levels[2].rgba[0], 51, 1) << "a quarter of the light of 100";
    EXPECT_NEAR(levels[2].rgba[1], 177, 1);
    EXPECT_EQ(alpha_coverage(levels[2], 0.5f), 1.0) << cutoff;
  }
}

TEST(MipLevels, WithoutAnAlphaTestTransparentTexelsShowTheirColour) {
  const auto levels = mip_levels(Image{2, 1, {255, 255, 255, 0, 0, 0, 0, 255}}, 0.0f);
  EXPECT_EQ(levels[0].rgba[0], 255);
  EXPECT_EQ(levels[1].rgba[0], 188);
}

TEST(MipLevels, LevelZeroKeepsItsAlphaAndItsSolidColours) {
  const Image image = discs(32, 8, 2.5, {200, 30, 90});
  const Image level = mip_levels(image, 0.5f)[0];
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    ASSERT_EQ(level.rgba[i + 3], image.rgba[i + 3]);
    if (image.rgba[i + 3] == 0) continue;
    for (std::size_t channel = 0; channel < 3; ++channel) ASSERT_EQ(level.rgba[i + channel], image.rgba[i + channel]);
  }
}

// Irregular, so that alpha takes many values and the scale can be fine.
Image speckles(std::uint32_t side, std::uint32_t share_of_256) {
  Image image{side, side, {}};
  std::uint32_t state = 1;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    state = state * 1664525u + 1013904223u;
    image.rgba.insert(image.rgba.end(), {10, 120, 10, static_cast<std::uint8_t>((state >> 24) < share_of_256 ? 255 : 0)});
  }
  return image;
}

TEST(MipLevels, CoverageIsKept) {
  for (std::uint32_t share : {40u, 100u, 200u}) {
    const Image image = speckles(256, share);
    const double target = alpha_coverage(image, 0.5f);
    const auto levels = mip_levels(image, 0.5f);
    // An average of 4 or 16 texels takes few values, so levels 1 and 2 can only come near.
    for (std::size_t level = 3; level + 3 < levels.size(); ++level)
      EXPECT_NEAR(alpha_coverage(levels[level], 0.5f), target, 0.04) << "level " << level << ", share " << share;
  }
}

TEST(MipLevels, PlainAveragingWouldLoseThinLeaves) {
  // A sixth of the texels are solid: no average of 16 reaches one half, so without scaling level 2 would be empty.
  const Image image = discs(128, 16, 3.6, {10, 120, 10});
  const double target = alpha_coverage(image, 0.5f);
  EXPECT_LT(target, 0.2);
  const auto levels = mip_levels(image, 0.5f);
  EXPECT_NEAR(alpha_coverage(levels[2], 0.5f), target, 0.1);
  for (const Image& level : levels) EXPECT_GT(alpha_coverage(level, 0.5f), 0.0) << level.width;
}

/// Leaves: ellipses of several sizes and angles, veined, with edges two texels soft, on transparent black.
Image leaves(std::uint32_t width, std::uint32_t height) {
  Image image{width, height, {}};
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      const double cell = 40.0, u = std::fmod(x, cell) - 20.0, v = std::fmod(y, cell) - 20.0;
      const double angle = std::floor(x / cell) * 0.7 + std::floor(y / cell) * 1.9;
      const double along = u * std::cos(angle) + v * std::sin(angle), across = v * std::cos(angle) - u * std::sin(angle);
      const double outside = std::hypot(along / 18.0, across / 7.0) * 7.0 - 7.0;
      const double alpha = std::clamp(0.5 - outside / 2.0, 0.0, 1.0), vein = 0.5 + 0.5 * std::sin(3.0 * along + std::abs(across));
      const std::array<double, 4> texel{50.0 + 30.0 * vein, 110.0 + 60.0 * vein, 30.0 + 10.0 * vein, 255.0 * alpha};
      for (double value : texel) image.rgba.push_back(static_cast<std::uint8_t>(alpha > 0.0 ? std::lround(value) : 0));
    }
  return image;
}

Image opaque(Image image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
  return image;
}

struct Decoded {
  TextureLayout layout;
  std::vector<Image> levels;
};

Decoded decoded(const std::vector<std::uint8_t>& chunk) {
  Decoded result{test::must(read_texture(chunk)), {}};
  for (const MipLevel& level : result.layout.levels()) {
    Image image{level.width, level.height, std::vector<std::uint8_t>(std::size_t{level.width} * level.height * 4)};
    decode_texture_level(result.layout.format, level, std::span(chunk).subspan(level.offset, level.bytes), image.rgba);
    result.levels.push_back(std::move(image));
  }
  return result;
}

/// Peak signal to noise of the colours of texels that are solid in both.
double colour_psnr(const Image& a, const Image& b, float alpha_cutoff) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    if (!is_solid(a.rgba[i + 3], alpha_cutoff) || !is_solid(b.rgba[i + 3], alpha_cutoff)) continue;
    for (std::size_t channel = 0; channel < 3; ++channel, ++count)
      sum += std::pow(static_cast<double>(a.rgba[i + channel]) - b.rgba[i + channel], 2);
  }
  return count == 0.0 ? 0.0 : 10.0 * std::log10(255.0 * 255.0 * count / std::max(sum, 1e-9));
}

TEST(EncodeTexture, AlphaIsStoredWhereItIsTested) {
  const auto format = [](const Image& image, float cutoff) {
    return decoded(*encode_texture(image, cutoff, TextureCoding::bc)).layout.format;
  };
  EXPECT_EQ(format(leaves(64, 64), 0.5f), std::uint32_t{COPPICE_TEXTURE_BC3});
  EXPECT_EQ(format(leaves(64, 64), 0.0f), std::uint32_t{COPPICE_TEXTURE_BC1});
  EXPECT_EQ(format(opaque(leaves(64, 64)), 0.5f), std::uint32_t{COPPICE_TEXTURE_BC1});
}

TEST(EncodeTexture, Rgba8IsTheMipLevels) {
  const Image image = leaves(61, 34);
  const Decoded stored = decoded(*encode_texture(image, 0.4f, TextureCoding::rgba8));
  const std::vector<Image> levels = mip_levels(image, 0.4f);
  ASSERT_EQ(stored.levels.size(), levels.size());
  for (std::size_t i = 0; i < levels.size(); ++i) EXPECT_EQ(stored.levels[i].rgba, levels[i].rgba) << i;
}

/// Sides of every remainder by four, so that last blocks of all widths are met.
TEST(EncodeTexture, NoTexelCrossesTheAlphaTest) {
  for (const float cutoff : {0.1f, 0.33f, 0.5f, 128.0f / 255.0f, 0.75f, 1.0f})
    for (const std::uint32_t width : {200u, 201u, 202u, 203u}) {
      const Image image = leaves(width, 161);
      const std::vector<Image> levels = mip_levels(image, cutoff);
      const Decoded stored = decoded(*encode_texture(image, cutoff, TextureCoding::bc));
      ASSERT_EQ(stored.levels.size(), levels.size());
      for (std::size_t i = 0; i < levels.size(); ++i) {
        ASSERT_GT(alpha_coverage(levels[i], cutoff), 0.0) << i;
        ASSERT_EQ(alpha_coverage(stored.levels[i], cutoff), alpha_coverage(levels[i], cutoff)) << "level " << i << ", cutoff " << cutoff;
      }
    }
}

TEST(EncodeTexture, AlphasAndColoursStayNear) {
  const Image image = leaves(203, 161);
  const std::vector<Image> levels = mip_levels(image, 0.5f);
  const Decoded masked = decoded(*encode_texture(image, 0.5f, TextureCoding::bc));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_GT(colour_psnr(levels[i], masked.levels[i], 0.5f), 32.0) << i;
  double worst = 0.0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    worst = std::max(worst, std::abs(static_cast<double>(levels[0].rgba[i]) - masked.levels[0].rgba[i]));
  EXPECT_LE(worst, 55.0) << "one and a half of the seven steps between 0 and 255";
  const Image solid = opaque(image);
  const Decoded plain = decoded(*encode_texture(solid, 0.0f, TextureCoding::bc));
  EXPECT_GT(colour_psnr(solid, plain.levels[0], 0.5f), 32.0);
  for (std::size_t i = 3; i < plain.levels[0].rgba.size(); i += 4) ASSERT_EQ(plain.levels[0].rgba[i], 255);
}

TEST(EncodeTexture, OneColourIsKeptToTheStepsOf565) {
  Image image{4, 4, {}};
  for (int i = 0; i < 16; ++i) image.rgba.insert(image.rgba.end(), {77, 133, 9, 255});
  const Decoded stored = decoded(*encode_texture(image, 0.0f, TextureCoding::bc));
  for (std::size_t i = 0; i < image.rgba.size(); ++i) ASSERT_NEAR(stored.levels[0].rgba[i], image.rgba[i], 2) << i;
}

TEST(EncodeTexture, RefusesAnImageOfTheWrongLength) {
  for (const TextureCoding coding : {TextureCoding::bc, TextureCoding::rgba8}) {
    EXPECT_EQ(encode_texture(Image{2, 2, std::vector<std::uint8_t>(15)}, 0.0f, coding).error().status, Status::invalid_argument);
    EXPECT_EQ(encode_texture(Image{}, 0.0f, coding).error().status, Status::invalid_argument);
  }
}

}  // namespace coppice::bake::texture_encode_test
