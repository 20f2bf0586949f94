#include "mutual_information.h"

#include <cmath>

#include <gtest/gtest.h>

#include "collapse_information.h"
#include "item_areas.h"
#include "results.h"
#include "test_foliage.h"
#include "visibility.h"

namespace coppice::bake::mutual_information_test {

double bits(const std::vector<std::uint32_t>& areas_px, const std::vector<std::uint32_t>& totals_px) {
  return to_bits(outcome_information(areas_px, view_totals(totals_px)));
}

TEST(OutcomeInformation, IsNoneInOneViewWithTheSameShareInAllAndUnseen) {
  for (const std::uint32_t area : {0u, 1u, 17u, 99u, 100u}) EXPECT_EQ(bits({area}, {100}), 0.0) << area;
  EXPECT_EQ(bits({5, 5, 5, 5}, {65536, 65536, 65536, 65536}), 0.0);
  EXPECT_EQ(bits({3, 6, 9}, {10, 20, 30}), 0.0);
  EXPECT_EQ(bits({77777, 77777}, {100000, 100000}), 0.0);
  EXPECT_EQ(bits({0, 0, 0}, {10, 10, 10}), 0.0);
}

TEST(OutcomeInformation, OfKnownShares) {
  // p(l|1) = 1, p(l|2) = 0, p(l) = 1/2: (1/2) * 1 * log2(1 / (1/2)).
  EXPECT_EQ(bits({100, 0}, {100, 100}), 0.5);
  EXPECT_EQ(bits({0, 7}, {100, 7}), 0.5);
  EXPECT_EQ(bits({100, 0}, {100, 0}), 0.5) << "an empty view has no shares";
  // p(l) = 1/2: (1/2) (1/4 log2(1/2) + 3/4 log2(3/2)).
  const double expected = 0.5 * (-0.25 + 0.75 * std::log2(1.5));
  EXPECT_NEAR(bits({25, 75}, {100, 100}), expected, 1e-12);
  EXPECT_NEAR(bits({10, 60}, {40, 80}), expected, 1e-12) << "shares, not areas";
  EXPECT_NEAR(bits({1000000, 3000000}, {4000000, 4000000}), expected, 1e-12) << "beyond the table of logarithms";
}

TEST(OutcomeInformation, IsNeverNegative) {
  std::mt19937 random(7);
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::uint32_t> areas(20), totals(20);
    const std::uint32_t spread = 1 + static_cast<std::uint32_t>(random() % 40);
    for (std::size_t v = 0; v < 20; ++v) {
      totals[v] = static_cast<std::uint32_t>(random() % 65536);
      areas[v] = std::min(totals[v], static_cast<std::uint32_t>(random() % spread));
    }
    ASSERT_GE(outcome_information(areas, view_totals(totals)), 0);
  }
}

/// In pictures of 64 px.
double source_bits(const Foliage& foliage, const std::vector<Viewpoint>& views, bool count_background) {
  return test::must(collapse_by_mutual_information({foliage, test::plain_materials(), {}}, views, {64, count_background, 8}, {}))
      .source.bits;
}

TEST(FoliageInformation, TwoLeavesEachSeenByOneOfTwoViews) {
  // One behind the other, seen from the front and the back: each view sees all of one of them.
  const Foliage foliage =
      test::plain_foliage({test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), test::rectangle({0, 0, 1}, {1, 0, 0}, {0, 1, 0})});
  const Viewpoint front = viewpoint_towards({0, 0, 1}), back = viewpoint_towards({0, 0, -1});
  // Each leaf fills 36 x 36 of the 64 x 64 pixels in its view (visibility_test.cpp) and none of the other: p(l|v) = s, p(l) = s / 2,
  // I(V,l) = (1/2) s log2 2 = s / 2. The background has the same share in both. I(V,L) = s.
  EXPECT_NEAR(source_bits(foliage, {front, back}, true), 36.0 * 36.0 / 4096.0, 1e-11);
  // Without the background each leaf is all there is in its view: s = 1.
  EXPECT_EQ(source_bits(foliage, {front, back}, false), 1.0);
  for (const bool count_background : {true, false}) EXPECT_EQ(source_bits(foliage, {front}, count_background), 0.0) << "one view";
}

TEST(FoliageInformation, TheBackgroundIsAnOutcome) {
  const Foliage foliage = test::plain_foliage({test::rectangle({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0})});
  const std::vector<Viewpoint> views{viewpoint_towards({0, 0, 1}), viewpoint_towards({1, 0, 0})};
  // The square fills 45 or 46 of 64 columns of one view, edge-on in the other. s: its share.
  const auto buffers = test::must(render_item_buffers({foliage, test::plain_materials(), {}}, views, 64));
  const double s = leaf_areas_px(buffers)[0] / 4096.0;
  ASSERT_GT(s, 0.45);
  const double leaf = 0.5 * s;  // (1/2) s log2(s / (s/2))
  const double b = 1 - s / 2;   // p(background)
  const double background = 0.5 * ((1 - s) * std::log2((1 - s) / b) + std::log2(1 / b));
  EXPECT_NEAR(source_bits(foliage, views, true), leaf + background, 1e-11);
  EXPECT_EQ(source_bits(foliage, views, false), 0.5);  // p(l|1) = 1, nothing in view 2
}

}  // namespace coppice::bake::mutual_information_test
