// The comparison that golden images rest on: what it must let pass and what it must not.

#include <cstdint>

#include <gtest/gtest.h>

#include "golden.h"
#include "process.h"

namespace golden_compare_test {

using coppice::test::compare_pictures;
using coppice::test::Picture;
using coppice::test::within;

Picture grey_picture(std::uint32_t width_px, std::uint32_t height_px) {
  return {width_px, height_px, std::vector<std::uint8_t>(std::size_t{width_px} * height_px * 4, 128)};
}

TEST(GoldenCompare, EqualPicturesDoNotDifferAndAnotherSizeIsNeverWithin) {
  const auto difference = compare_pictures(grey_picture(10, 10), grey_picture(10, 10), 0);
  EXPECT_EQ(difference.largest_delta, 0u);
  EXPECT_EQ(difference.differing_share, 0.0);
  EXPECT_TRUE(within(difference, {0, 0.0, 0}));
  EXPECT_FALSE(within(compare_pictures(grey_picture(10, 10), grey_picture(10, 11), 255), {255, 1.0, 255}));
}

TEST(GoldenCompare, OneChannelOfOnePixelCounts) {
  for (std::size_t channel = 0; channel < 4; ++channel) {
    Picture actual = grey_picture(10, 10);
    actual.rgba[4 * 37 + channel] = 123;  // 5 away
    const auto at_5 = compare_pictures(grey_picture(10, 10), actual, 5);
    EXPECT_EQ(at_5.largest_delta, 5u);
    EXPECT_EQ(at_5.differing_share, 0.0);
    const auto at_4 = compare_pictures(grey_picture(10, 10), actual, 4);
    EXPECT_DOUBLE_EQ(at_4.differing_share, 0.01);
    EXPECT_TRUE(within(at_4, {4, 0.01, 5}));
    EXPECT_FALSE(within(at_4, {4, 0.009, 5}));
    EXPECT_FALSE(within(at_4, {4, 0.01, 4}));
    EXPECT_GT(at_4.picture.rgba[4 * 37], at_4.picture.rgba[4 * 37 + 1]) << "the differing pixel is red";
    EXPECT_EQ(at_4.picture.rgba[4 * 36], at_4.picture.rgba[4 * 36 + 1]) << "its neighbour is grey";
  }
}

TEST(GoldenCompare, PngKeepsEveryByte) {
  const coppice::test::TemporaryFolder folder;
  Picture picture = grey_picture(7, 5);
  for (std::size_t i = 0; i < picture.rgba.size(); ++i) picture.rgba[i] = static_cast<std::uint8_t>(31 * i);
  coppice::test::write_png(folder / "p.png", picture);
  const Picture back = coppice::test::read_png(folder / "p.png");
  EXPECT_EQ(back.width_px, 7u);
  EXPECT_EQ(back.height_px, 5u);
  EXPECT_EQ(back.rgba, picture.rgba);
  EXPECT_THROW(static_cast<void>(coppice::test::read_png(folder / "missing.png")), std::runtime_error);
}

}  // namespace golden_compare_test
