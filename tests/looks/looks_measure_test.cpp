// The measures on pictures whose differences are known.

#include "looks_measure.h"

#include <functional>

#include <gtest/gtest.h>

namespace coppice::test::looks_measure_test {

constexpr std::uint32_t kSidePx = 64;
constexpr glm::vec4 kNothing{120, 90, 140, 0}, kGreen{60, 140, 40, 1}, kBrown{110, 80, 50, 1};

MeanPicture picture_of(const std::function<glm::vec4(std::uint32_t x, std::uint32_t y)>& texel) {
  MeanPicture picture{kSidePx, kSidePx, {}};
  for (std::uint32_t y = 0; y < kSidePx; ++y)
    for (std::uint32_t x = 0; x < kSidePx; ++x) picture.texels.push_back(texel(x, y));
  return picture;
}

bool in(std::uint32_t at, std::uint32_t low, std::uint32_t high) {
  return at >= low && at < high;
}

/// A green crown over a brown trunk of two pixels.
glm::vec4 tree(std::uint32_t x, std::uint32_t y) {
  if (in(x, 8, 56) && in(y, 4, 36)) return kGreen;
  return in(x, 31, 33) && in(y, 36, 60) ? kBrown : kNothing;
}

TEST(LooksMeasure, ATreeIsLikeItself) {
  const LooksDifference difference = compare_looks(picture_of(tree), picture_of(tree));
  EXPECT_EQ(difference.blocks, 30u) << "6 columns of 5, of which the first and the last are half crown; a block of trunk is an eighth";
  EXPECT_EQ(difference.wrong_blocks, 0.0);
  EXPECT_DOUBLE_EQ(difference.coverage, 1.0);
  EXPECT_DOUBLE_EQ(difference.largest_piece, 1.0);
  EXPECT_TRUE(looks_alike(difference));
}

TEST(LooksMeasure, ColoursAreComparedBlockByBlock) {
  const auto shifted = [](float by) {
    return picture_of([by](std::uint32_t x, std::uint32_t y) { return tree(x, y) + glm::vec4(0, by * tree(x, y).a, 0, 0); });
  };
  EXPECT_TRUE(looks_alike(compare_looks(picture_of(tree), shifted(14))));
  EXPECT_FALSE(looks_alike(compare_looks(picture_of(tree), shifted(16)))) << "6 % of 255 are 15.3";
  // Two of 30 blocks are let pass, three are more than 5 %.
  const auto spotted = [](std::uint32_t width_px) {
    return picture_of([=](std::uint32_t x, std::uint32_t y) {
      return in(x, 16, 16 + width_px) && in(y, 16, 24) ? glm::vec4(255, 255, 255, 1) : tree(x, y);
    });
  };
  EXPECT_TRUE(looks_alike(compare_looks(picture_of(tree), spotted(16))));
  EXPECT_FALSE(looks_alike(compare_looks(picture_of(tree), spotted(24))));
}

TEST(LooksMeasure, NoiseThatABlockEvensOutIsNone) {
  const MeanPicture noisy = picture_of([](std::uint32_t x, std::uint32_t y) {
    const glm::vec4 texel = tree(x, y);
    return texel + ((x + y) % 2 == 0 ? 60.0f : -60.0f) * glm::vec4(texel.a, texel.a, texel.a, 0);
  });
  EXPECT_TRUE(looks_alike(compare_looks(picture_of(tree), noisy)));
}

TEST(LooksMeasure, APlantIsNoFatterOrThinner) {
  const auto wide = [](std::uint32_t columns) {
    return picture_of([=](std::uint32_t x, std::uint32_t y) {
      return in(x, 56, 56 + columns) && in(y, 4, 36) ? kNothing + glm::vec4(0, 0, 0, 1) : tree(x, y);
    });
  };
  EXPECT_TRUE(looks_alike(compare_looks(picture_of(tree), wide(2))));
  EXPECT_FALSE(looks_alike(compare_looks(picture_of(tree), wide(3)))) << "96 px more than 1584 are 6 %";
}

TEST(LooksMeasure, ATrunkIsNoSpike) {
  const auto spike = [](std::uint32_t rows) {
    return picture_of([=](std::uint32_t x, std::uint32_t y) {
      glm::vec4 texel = tree(x, y);
      if (in(y, 60 - rows, 60)) texel.a *= 0.4f;
      return texel;
    });
  };
  EXPECT_TRUE(looks_alike(compare_looks(picture_of(tree), spike(7)))) << "a tenth of the rows, and two";
  const LooksDifference difference = compare_looks(picture_of(tree), spike(12));
  EXPECT_NEAR(difference.coverage, 1.0, 0.01);
  EXPECT_DOUBLE_EQ(difference.wrong_rows, 10.0 / 56.0);
  EXPECT_FALSE(looks_alike(difference));
}

TEST(LooksMeasure, ACrownDoesNotFloat) {
  const auto two_crowns = [](bool trunk) {
    return picture_of([=](std::uint32_t x, std::uint32_t y) {
      if (in(x, 8, 56) && (in(y, 4, 24) || in(y, 44, 60))) return kGreen;
      return trunk && in(x, 31, 32) && in(y, 24, 44) ? kBrown : kNothing;
    });
  };
  const LooksDifference difference = compare_looks(two_crowns(true), two_crowns(false));
  EXPECT_NEAR(difference.largest_piece, 20.0 / 36.0, 1e-9);
  EXPECT_DOUBLE_EQ(difference.reference_largest_piece, 1.0);
  EXPECT_NEAR(difference.coverage, 1.0, 0.02);
  EXPECT_EQ(difference.wrong_blocks, 0.0);
  EXPECT_FALSE(looks_alike(difference));
}

TEST(LooksMeasure, PiecesTouchAtCorners) {
  const MeanPicture steps = picture_of([](std::uint32_t x, std::uint32_t y) { return x / 8 == y / 8 ? kGreen : kNothing; });
  EXPECT_DOUBLE_EQ(compare_looks(steps, steps).largest_piece, 1.0);
}

TEST(LooksMeasure, AThinPlantHasNoBlocks) {
  const auto stem = [](std::uint32_t height_px) {
    return picture_of([=](std::uint32_t x, std::uint32_t y) { return x == 30 && y < height_px ? kBrown : kNothing; });
  };
  EXPECT_EQ(compare_looks(stem(60), stem(60)).blocks, 0u);
  EXPECT_TRUE(looks_alike(compare_looks(stem(60), stem(58))));
  EXPECT_FALSE(looks_alike(compare_looks(stem(60), stem(50))));
}

TEST(LooksMeasure, NothingToCompareIsAnError) {
  const MeanPicture nothing = picture_of([](std::uint32_t, std::uint32_t) { return kNothing; });
  EXPECT_THROW((void)compare_looks(nothing, nothing), std::runtime_error);
  EXPECT_THROW((void)compare_looks(picture_of(tree), MeanPicture{8, 8, std::vector<glm::vec4>(64)}), std::runtime_error);
}

}  // namespace coppice::test::looks_measure_test
