#include "texture_mips.h"

#include <gtest/gtest.h>

#include <cmath>

namespace coppice::bake {
namespace texture_mips_test {

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
  Image image{3, 1, {0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255}};
  const auto levels = mip_levels(image, 0.0f);
  ASSERT_EQ(levels.size(), 2u);
  EXPECT_EQ(levels[1].rgba[0], 156);  // a third of the light
}

TEST(MipLevels, HolesTakeTheColourAroundThem) {
  const auto levels = mip_levels(discs(64, 16, 5.0, {40, 160, 20}), 0.5f);
  for (const Image& level : levels)
    for (std::size_t i = 0; i < level.rgba.size(); i += 4) {
      ASSERT_NEAR(level.rgba[i], 40, 1);
      ASSERT_NEAR(level.rgba[i + 1], 160, 1);
      ASSERT_NEAR(level.rgba[i + 2], 20, 1);
    }
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

TEST(MipLevels, TexelsThatTheAlphaTestDiscardsLendNoColour) {
  const auto levels = mip_levels(Image{2, 1, {255, 0, 255, 100, 0, 128, 0, 200}}, 0.5f);
  for (const Image& level : levels)
    for (std::size_t i = 0; i < level.rgba.size(); i += 4) EXPECT_EQ(level.rgba[i + 1], 128);
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

}  // namespace texture_mips_test
}  // namespace coppice::bake
