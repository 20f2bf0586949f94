#include "mutual_information.h"

#include <cmath>

#include <gtest/gtest.h>

#include "collapse_information.h"
#include "item_areas.h"
#include "results.h"
#include "test_foliage.h"
#include "visibility.h"

namespace coppice::bake {
namespace mutual_information_test {

double bits(const std::vector<std::uint32_t>& areas_px, const std::vector<std::uint32_t>& totals_px) {
  return to_bits(outcome_information(areas_px, view_totals(totals_px)));
}

TEST(OutcomeInformation, OneViewTellsNothing) {
  for (const std::uint32_t area : {0u, 1u, 17u, 99u, 100u}) EXPECT_EQ(bits({area}, {100}), 0.0) << area;
}

TEST(OutcomeInformation, TheSameShareInEveryViewTellsNothing) {
  EXPECT_EQ(bits({5, 5, 5, 5}, {65536, 65536, 65536, 65536}), 0.0);
  EXPECT_EQ(bits({3, 6, 9}, {10, 20, 30}), 0.0);
  EXPECT_EQ(bits({77777, 77777}, {100000, 100000}), 0.0);
}

TEST(OutcomeInformation, AnUnseenLeafHasNone) {
  EXPECT_EQ(bits({0, 0, 0}, {10, 10, 10}), 0.0);
}

TEST(OutcomeInformation, ALeafThatFillsOneOfTwoViewsHasHalfABit) {
  // p(l|1) = 1, p(l|2) = 0, p(l) = 1/2: (1/2) * 1 * log2(1 / (1/2)).
  EXPECT_EQ(bits({100, 0}, {100, 100}), 0.5);
  EXPECT_EQ(bits({0, 7}, {100, 7}), 0.5);
}

TEST(OutcomeInformation, SharesOfAQuarterAndThreeQuarters) {
  // p(l) = 1/2: (1/2) (1/4 log2(1/2) + 3/4 log2(3/2)).
  EXPECT_NEAR(bits({25, 75}, {100, 100}), 0.5 * (-0.25 + 0.75 * std::log2(1.5)), 1e-12);
  // Shares, not areas: the same in views of different totals.
  EXPECT_NEAR(bits({10, 60}, {40, 80}), 0.5 * (-0.25 + 0.75 * std::log2(1.5)), 1e-12);
}

TEST(OutcomeInformation, AreasBeyondTheTableOfLogarithms) {
  EXPECT_NEAR(bits({1000000, 3000000}, {4000000, 4000000}), 0.5 * (-0.25 + 0.75 * std::log2(1.5)), 1e-12);
}

TEST(OutcomeInformation, AnEmptyViewHasNoShares) {
  // p(l|2) = 0 because nothing is visible there: p(l) = 1/2 as above.
  EXPECT_EQ(bits({100, 0}, {100, 0}), 0.5);
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

/// Two squares, one behind the other, seen from the front and the back: each view sees one of them, all of it.
struct TwoViews {
  Foliage foliage;
  std::vector<Viewpoint> views{viewpoint_towards({0, 0, 1}), viewpoint_towards({0, 0, -1})};
  CollapseOptions options{64, true, 8};
};

TwoViews back_to_back() {
  TwoViews scene;
  scene.foliage = test::plain_foliage({test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), test::rectangle({0, 0, 1}, {1, 0, 0}, {0, 1, 0})});
  return scene;
}

double source_bits(const TwoViews& scene) {
  const auto result =
      test::must(collapse_by_mutual_information({scene.foliage, test::plain_materials(), {}}, scene.views, scene.options, {}));
  return result.source.bits;
}

TEST(FoliageInformation, TwoLeavesEachSeenByOneOfTwoViews) {
  TwoViews scene = back_to_back();
  // Each leaf fills 36 x 36 of the 64 x 64 pixels in its view (visibility_test.cpp) and none of the other: p(l|v) = s, p(l) = s / 2,
  // I(V,l) = (1/2) s log2 2 = s / 2. The background has the same share in both. I(V,L) = s.
  EXPECT_NEAR(source_bits(scene), 36.0 * 36.0 / 4096.0, 1e-11);
  // Without the background each leaf is all there is in its view: s = 1.
  scene.options.count_background = false;
  EXPECT_EQ(source_bits(scene), 1.0);
}

TEST(FoliageInformation, OneViewTellsNothing) {
  TwoViews scene = back_to_back();
  scene.views.resize(1);
  for (const bool count_background : {true, false}) {
    scene.options.count_background = count_background;
    EXPECT_EQ(source_bits(scene), 0.0);
  }
}

TEST(FoliageInformation, TheBackgroundIsAnOutcome) {
  TwoViews scene;
  scene.foliage = test::plain_foliage({test::rectangle({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0})});
  scene.views = {viewpoint_towards({0, 0, 1}), viewpoint_towards({1, 0, 0})};
  // The square fills 45 or 46 of 64 columns of one view, edge-on in the other. s: its share.
  const auto buffers = test::must(render_item_buffers({scene.foliage, test::plain_materials(), {}}, scene.views, 64));
  const double s = leaf_areas_px(buffers)[0] / 4096.0;
  ASSERT_GT(s, 0.45);
  const double leaf = 0.5 * s;  // (1/2) s log2(s / (s/2))
  const double b = 1 - s / 2;   // p(background)
  const double background = 0.5 * ((1 - s) * std::log2((1 - s) / b) + std::log2(1 / b));
  EXPECT_NEAR(source_bits(scene), leaf + background, 1e-11);
  scene.options.count_background = false;
  EXPECT_EQ(source_bits(scene), 0.5);  // p(l|1) = 1, nothing in view 2
}

}  // namespace mutual_information_test
}  // namespace coppice::bake
