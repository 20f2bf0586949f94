// Stochastic transparency: which pixels of merged leaves are drawn.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "coppice_transparency.h"
#include "tree.h"

namespace coppice::gpu::transparency_test {

constexpr std::uint32_t kLeaves = 48;
constexpr double kStep = 1.0 / 16;

std::uint32_t name_of(std::uint32_t leaf) {
  return leaf_name(leaf * 65537u, leaf, 77u, 3u);
}

/// Share of an 8 x 8 tile that every one of some leaves shows.
double shown_share(std::initializer_list<std::uint32_t> dithers, std::uint32_t side = 8) {
  std::uint32_t shown = 0;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x)
      shown += std::ranges::all_of(dithers, [&](std::uint32_t dither) { return shows_pixel(dither, 900 + x, 500 + y); });
  return shown / static_cast<double>(side * side);
}

TEST(Transparency, ALeafsWordHoldsItsCardAndItsTransparency) {
  for (std::uint8_t opacity = 1; opacity <= kOpaque; ++opacity) {
    const std::uint32_t word = 0xfff0abcdu | transparency_of(opacity) << kTransparencyShift;
    EXPECT_EQ(card_of_leaf(word), 0xabcdu);
    EXPECT_EQ(transparency_of_leaf(word), transparency_of(opacity)) << int{opacity};
  }
}

TEST(Transparency, AnOpaqueLeafIsDrawnWhole) {
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (const std::uint32_t frame : {0u, 1u, 1000u}) {
      const std::uint32_t dither = leaf_dither(0, name_of(leaf), frame, leaf, 2 * leaf);
      EXPECT_EQ(dither, 0u);
      EXPECT_EQ(shown_share({dither}), 1.0);
    }
}

TEST(Transparency, AnyTileShowsTheOpacity) {
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (std::uint32_t transparency = 1; transparency <= kMaxTransparency; ++transparency)
      for (std::uint32_t frame = 0; frame < 16; ++frame) {
        const std::uint32_t dither = leaf_dither(transparency, name_of(leaf), frame, 10, 20);
        EXPECT_NEAR(shown_share({dither}), static_cast<double>(opacity_of(transparency)), kStep)
            << leaf << ' ' << transparency << ' ' << frame;
        EXPECT_NEAR(shown_share({dither}, 4), static_cast<double>(opacity_of(transparency)), 1.5 * kStep)
            << leaf << ' ' << transparency << ' ' << frame;
      }
}

TEST(Transparency, FramesShowTheOpacityInEveryPixel) {
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (std::uint32_t transparency = 1; transparency <= kMaxTransparency; ++transparency) {
      const auto share = [&](std::uint32_t frames, std::uint32_t x, std::uint32_t y) {
        double shown = 0;
        for (std::uint32_t frame = 1; frame <= frames; ++frame)
          shown += shows_pixel(leaf_dither(transparency, name_of(leaf), frame, 0, 0), x, y);
        return shown / frames;
      };
      for (std::uint32_t pixel = 0; pixel < 64; ++pixel) {
        EXPECT_NEAR(share(16, pixel % 8, pixel / 8), static_cast<double>(opacity_of(transparency)), 2 * kStep)
            << leaf << ' ' << transparency;
        EXPECT_NEAR(share(64, pixel % 8, pixel / 8), static_cast<double>(opacity_of(transparency)), 0.6 * kStep)
            << leaf << ' ' << transparency;
      }
    }
}

/// What two leaves of half opacity both show is a quarter, over a tile and 16 frames; over all pairs in the mean, where some are alike.
TEST(Transparency, LeavesDoNotFollowEachOther) {
  double sum = 0, squares = 0;
  std::uint32_t pairs = 0;
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (std::uint32_t other = leaf + 1; other < kLeaves; ++other, ++pairs) {
      double both = 0;
      for (std::uint32_t frame = 1; frame <= 16; ++frame)
        both += shown_share({leaf_dither(8, name_of(leaf), frame, 0, 0), leaf_dither(8, name_of(other), frame, 0, 0)}) / 16;
      sum += both - 0.25;
      squares += (both - 0.25) * (both - 0.25);
    }
  EXPECT_LT(std::abs(sum / pairs), 0.01);
  EXPECT_LT(std::sqrt(squares / pairs), 0.05);
}

TEST(Transparency, NeighboursInATreeAndInstancesHaveOtherNames) {
  const std::uint32_t name = leaf_name(1, 2, 3, 4);
  for (const std::uint32_t other : {leaf_name(2, 2, 3, 4), leaf_name(1, 3, 3, 4), leaf_name(1, 2, 4, 4), leaf_name(1, 2, 3, 5)})
    EXPECT_NE(name, other);
}

TEST(Transparency, TheFixedPatternMovesWithTheLeaf) {
  for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
    for (std::uint32_t pixel = 0; pixel < 64; ++pixel) {
      const std::uint32_t x = pixel % 8, y = pixel / 8;
      EXPECT_EQ(shows_pixel(leaf_dither(7, name_of(leaf), 0, 100, 50), 100 + x, 50 + y),
                shows_pixel(leaf_dither(7, name_of(leaf), 0, 731, 12), 731 + x, 12 + y));
    }
}

}  // namespace coppice::gpu::transparency_test
