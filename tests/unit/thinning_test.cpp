// Which pixels of leaves with gaps are drawn.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "coppice_thinning.h"
#include "tree.h"

namespace coppice::gpu {
namespace thinning_test {

constexpr std::uint32_t kLeaves = 48;
constexpr double kStep = 1.0 / 16;

std::uint32_t name_of(std::uint32_t leaf) {
  return leaf_name(leaf * 65537u, leaf, 77u, 3u);
}

/// Share of an 8 x 8 tile that every one of some leaves shows.
double shown_share(std::initializer_list<std::uint32_t> thinnings, std::uint32_t side = 8) {
  std::uint32_t shown = 0;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x)
      shown += std::ranges::all_of(thinnings, [&](std::uint32_t thinning) { return shows_pixel(thinning, 900 + x, 500 + y); });
  return shown / static_cast<double>(side * side);
}

TEST(Thinning, GapsAreWhatIsMissingToSixteenSixteenths) {
  EXPECT_EQ(gaps_of(kNoFade), 0u);
  EXPECT_EQ(gaps_of(0x80), kMaxGaps) << "opacity 1 of 16";
  EXPECT_EQ(gaps_of(0x07), 8u) << "whatever the brightness";
  EXPECT_EQ(opacity_of(0), 1.0f);
  EXPECT_EQ(opacity_of(8), 0.5f);
}

TEST(Thinning, ALeafsWordHoldsItsCardItsGapsAndItsBrightness) {
  for (std::uint32_t fade = 0; fade < 256; ++fade) {
    const auto byte = static_cast<std::uint8_t>(fade);
    const std::uint32_t word = 0xff00abcdu | gaps_of(byte) << kGapShift | std::uint32_t{brightness_of(byte)} << kBrightnessShift;
    EXPECT_EQ(card_of_leaf(word), 0xabcdu);
    EXPECT_EQ(gaps_of_leaf(word), gaps_of(byte)) << fade;
    EXPECT_EQ(brightness_of_leaf(word), linear_brightness(byte)) << fade;
  }
}

TEST(Thinning, ALeafWithoutGapsIsDrawnWhole) {
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (const std::uint32_t frame : {0u, 1u, 1000u}) {
      const std::uint32_t thinning = leaf_thinning(0, name_of(leaf), frame, leaf, 2 * leaf);
      EXPECT_EQ(thinning, 0u);
      EXPECT_EQ(shown_share({thinning}), 1.0);
    }
}

TEST(Thinning, AnyTileShowsTheOpacity) {
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (std::uint32_t gaps = 1; gaps <= kMaxGaps; ++gaps)
      for (std::uint32_t frame = 0; frame < 16; ++frame) {
        const std::uint32_t thinning = leaf_thinning(gaps, name_of(leaf), frame, 10, 20);
        EXPECT_NEAR(shown_share({thinning}), static_cast<double>(opacity_of(gaps)), kStep) << leaf << ' ' << gaps << ' ' << frame;
        EXPECT_NEAR(shown_share({thinning}, 4), static_cast<double>(opacity_of(gaps)), 1.5 * kStep) << leaf << ' ' << gaps << ' ' << frame;
      }
}

TEST(Thinning, FramesShowTheOpacityInEveryPixel) {
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (std::uint32_t gaps = 1; gaps <= kMaxGaps; ++gaps) {
      const auto share = [&](std::uint32_t frames, std::uint32_t x, std::uint32_t y) {
        double shown = 0;
        for (std::uint32_t frame = 1; frame <= frames; ++frame) shown += shows_pixel(leaf_thinning(gaps, name_of(leaf), frame, 0, 0), x, y);
        return shown / frames;
      };
      for (std::uint32_t pixel = 0; pixel < 64; ++pixel) {
        EXPECT_NEAR(share(16, pixel % 8, pixel / 8), static_cast<double>(opacity_of(gaps)), 2 * kStep) << leaf << ' ' << gaps;
        EXPECT_NEAR(share(64, pixel % 8, pixel / 8), static_cast<double>(opacity_of(gaps)), 0.6 * kStep) << leaf << ' ' << gaps;
      }
    }
}

/// What two leaves of half opacity both show is a quarter, over a tile and 16 frames; over all pairs in the mean, where some are alike.
TEST(Thinning, LeavesDoNotFollowEachOther) {
  double sum = 0, squares = 0;
  std::uint32_t pairs = 0;
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (std::uint32_t other = leaf + 1; other < kLeaves; ++other, ++pairs) {
      double both = 0;
      for (std::uint32_t frame = 1; frame <= 16; ++frame)
        both += shown_share({leaf_thinning(8, name_of(leaf), frame, 0, 0), leaf_thinning(8, name_of(other), frame, 0, 0)}) / 16;
      sum += both - 0.25;
      squares += (both - 0.25) * (both - 0.25);
    }
  EXPECT_LT(std::abs(sum / pairs), 0.01);
  EXPECT_LT(std::sqrt(squares / pairs), 0.05);
}

TEST(Thinning, NeighboursInATreeAndInstancesHaveOtherNames) {
  const std::uint32_t name = leaf_name(1, 2, 3, 4);
  for (const std::uint32_t other : {leaf_name(2, 2, 3, 4), leaf_name(1, 3, 3, 4), leaf_name(1, 2, 4, 4), leaf_name(1, 2, 3, 5)})
    EXPECT_NE(name, other);
}

TEST(Thinning, TheFixedPatternMovesWithTheLeaf) {
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (std::uint32_t pixel = 0; pixel < 64; ++pixel) {
      const std::uint32_t x = pixel % 8, y = pixel / 8;
      EXPECT_EQ(shows_pixel(leaf_thinning(7, name_of(leaf), 0, 100, 50), 100 + x, 50 + y),
                shows_pixel(leaf_thinning(7, name_of(leaf), 0, 731, 12), 731 + x, 12 + y));
    }
}

}  // namespace thinning_test
}  // namespace coppice::gpu
