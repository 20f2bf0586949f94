#include "pair_silhouette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "quad_merge.h"
#include "test_foliage.h"

namespace coppice::bake::pair_silhouette_test {

/// The mismatch of an opaque quad that replaces opaque leaves.
float opaque_mismatch_m2(const PairShape& shape) {
  return shape.mismatch_m2(1.0f, 1.0f);
}

TEST(PairShapes, TwoHalvesOfASquareGiveTheSquare) {
  const Quad left = test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 2, 0}), right = test::rectangle({1, 0, 0}, {1, 0, 0}, {0, 2, 0});
  const PairShapes shapes = pair_shapes(left, right);
  const Quad both = merged_quad(left, right, shapes.shapes[0].corners);
  EXPECT_NEAR(opaque_mismatch_m2(shapes.shapes[0]), 0.0f, 1e-5f);
  EXPECT_NEAR(shapes.shapes[0].covering_opacity(1.0f), 1.0f, 1e-5f);
  EXPECT_DOUBLE_EQ(quad_area(both), 4.0);
  // Corners as the first leaf has them: the card is shown the same way round.
  EXPECT_EQ(both[0], glm::vec3(0, 0, 0));
  EXPECT_EQ(both[1], glm::vec3(2, 0, 0));
  EXPECT_EQ(both[3], glm::vec3(0, 2, 0));
}

// Two pointed leaves on one stalk, far apart at their tips: one quad folded open like a V has a triangle for each.
TEST(PairShapes, TwoLeavesOfOneStalkGiveAV) {
  const Quad first{glm::vec3(0, 0, 0), {0.99f, 1, 0}, {1.01f, 1, 0}, {0.1f, 0, 0}};
  const Quad second{glm::vec3(0, 0, 0.02f), {-1.01f, 1, 0.02f}, {-0.99f, 1, 0.02f}, {0.1f, 0, 0.02f}};
  const PairShapes shapes = pair_shapes(first, second);
  const std::set<std::uint8_t> corners(shapes.shapes[0].corners.begin(), shapes.shapes[0].corners.end());
  EXPECT_EQ(corners.count(1) + corners.count(2), 1u) << "one tip of the first";
  EXPECT_EQ(corners.count(5) + corners.count(6), 1u) << "one tip of the second";
  const PairShape& largest = shapes.all().back();
  EXPECT_LT(opaque_mismatch_m2(shapes.shapes[0]), 0.25f * opaque_mismatch_m2(largest)) << "merge_corners spans both and the gap";
  EXPECT_LT(largest.covering_opacity(1.0f), 0.5f);
  EXPECT_LT(largest.mismatch_m2(1.0f, largest.covering_opacity(1.0f)), 0.6f * opaque_mismatch_m2(largest));
}

TEST(PairShapes, AreDistinctAndTheLastIsThePapers) {
  const Foliage foliage = test::random_quads(20, 11);
  for (std::size_t i = 0; i < 20; i += 2) {
    const PairShapes shapes = pair_shapes(foliage.quads[i], foliage.quads[i + 1]);
    ASSERT_GE(shapes.count, PairShapes::kOpaque + 1);
    ASSERT_LE(shapes.count, PairShapes::kMax);
    EXPECT_EQ(shapes.all().back().corners, merge_corners(foliage.quads[i], foliage.quads[i + 1]));
    std::set<PairCorners> distinct;
    for (const PairShape& shape : shapes.all().first(shapes.count - 1)) distinct.insert(shape.corners);
    EXPECT_EQ(distinct.size(), shapes.count - 1);
    for (const PairShape& shape : shapes.all()) EXPECT_GE(opaque_mismatch_m2(shape), opaque_mismatch_m2(shapes.shapes[0]));
  }
}

TEST(PairShape, MismatchIsWhatIsMissedAddedAndTooMuch) {
  // A pair of 3 m^2, a quad of 5 m^2, 2 m^2 of both.
  const PairShape shape{{}, 3.0f, 5.0f, 2.0f};
  EXPECT_FLOAT_EQ(shape.mismatch_m2(1.0f, 1.0f), 1.0f + 3.0f + 2.0f);  // missed, added, more than the pair
  EXPECT_FLOAT_EQ(shape.covering_opacity(1.0f), 0.6f);
  // 1 m^2 missed, 2 m^2 that lack 0.4, 3 m^2 that have 0.6 too much; both cover the same.
  EXPECT_NEAR(shape.mismatch_m2(1.0f, 0.6f), 1.0f + 2.0f * 0.16f + 3.0f * 0.36f, 1e-5f);
  EXPECT_FLOAT_EQ(shape.covering_opacity(0.5f), 0.3f);
  EXPECT_FLOAT_EQ((PairShape{{}, 3.0f, 2.0f, 2.0f}.covering_opacity(0.5f)), 0.5f);  // a smaller quad is no more opaque than its leaves
}

/// Whether a point of the picture plane is in one of a quad's triangles.
bool covers(const std::array<glm::dvec2, 4>& quad, const glm::dvec2& point) {
  const auto side = [&](std::size_t a, std::size_t b) {
    const glm::dvec2 ab = quad[b] - quad[a], ap = point - quad[a];
    return ab.x * ap.y - ab.y * ap.x;
  };
  const auto inside = [&](std::size_t b, std::size_t c) {
    const std::array sides{side(0, b), side(b, c), side(c, 0)};
    return std::all_of(sides.begin(), sides.end(), [](double s) { return s >= 0; }) ||
           std::all_of(sides.begin(), sides.end(), [](double s) { return s <= 0; });
  };
  return inside(1, 2) || inside(2, 3);
}

/// The mismatch measured on a grid that is eight times as fine.
double fine_mismatch(const Quad& first, const Quad& second, const Quad& merged) {
  double differing_m2 = 0.0, excess_m2 = 0.0;
  const double golden = (1 + std::sqrt(5.0)) / 2;
  for (const glm::dvec3& axis :
       {glm::dvec3{0, 1, golden}, {0, -1, golden}, {1, golden, 0}, {-1, golden, 0}, {golden, 0, 1}, {golden, 0, -1}}) {
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0.1, 0.2, 1), axis)), up = glm::normalize(glm::cross(axis, right));
    const auto flat = [&](const Quad& quad) {
      std::array<glm::dvec2, 4> points;
      for (std::size_t i = 0; i < 4; ++i) points[i] = {glm::dot(glm::dvec3(quad[i]), right), glm::dot(glm::dvec3(quad[i]), up)};
      return points;
    };
    const auto a = flat(first), b = flat(second), m = flat(merged);
    constexpr int kSteps = 128;
    constexpr double kExtent = 3.0;  // random_quads stay within it
    int differing = 0, excess = 0;
    for (int y = 0; y < kSteps; ++y)
      for (int x = 0; x < kSteps; ++x) {
        const glm::dvec2 point{kExtent * ((x + 0.5) / kSteps * 2 - 1), kExtent * ((y + 0.5) / kSteps * 2 - 1)};
        const bool before = covers(a, point) || covers(b, point), after = covers(m, point);
        differing += before != after ? 1 : 0;
        excess += (after ? 1 : 0) - (before ? 1 : 0);
      }
    const double cell = 2 * kExtent / kSteps;
    differing_m2 += differing * cell * cell;
    excess_m2 += excess * cell * cell;
  }
  return (differing_m2 + std::abs(excess_m2)) / 6;
}

TEST(PairShapes, MismatchIsThatOfAFinerGridWithinItsCells) {
  const Quad point = test::rectangle({1, 2, 3}, {0, 0, 0}, {0, 0, 0});
  const PairShapes none = pair_shapes(point, point);
  for (const PairShape& shape : none.all()) EXPECT_EQ(opaque_mismatch_m2(shape), 0.0f) << "leaves without extent";
  const Foliage foliage = test::random_quads(12, 12);
  for (std::size_t i = 0; i < 12; i += 2) {
    const Quad &first = foliage.quads[i], &second = foliage.quads[i + 1];
    const PairShapes shapes = pair_shapes(first, second);
    for (const PairShape& shape : shapes.all()) {
      const double fine = fine_mismatch(first, second, merged_quad(first, second, shape.corners));
      EXPECT_NEAR(static_cast<double>(opaque_mismatch_m2(shape)), fine, 0.03 + 0.15 * fine) << i;
    }
  }
}

}  // namespace coppice::bake::pair_silhouette_test
