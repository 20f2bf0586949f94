#include "pair_silhouette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "quad_merge.h"
#include "test_foliage.h"

namespace coppice::bake {
namespace {

std::vector<PairShape> shapes_of(const Quad& first, const Quad& second, std::size_t count) {
  std::vector<PairShape> shapes(count);
  pair_shapes(first, second, shapes);
  return shapes;
}

TEST(PairShapes, TwoHalvesOfASquareGiveTheSquare) {
  const Quad left = test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 2, 0}), right = test::rectangle({1, 0, 0}, {1, 0, 0}, {0, 2, 0});
  const std::vector<PairShape> shapes = shapes_of(left, right, 3);
  const Quad both = merged_quad(left, right, shapes[0].corners);
  EXPECT_FLOAT_EQ(shapes[0].mismatch_m2, 0.0f);
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
  const std::vector<PairShape> shapes = shapes_of(first, second, 2);
  const std::set<std::uint8_t> corners(shapes[0].corners.begin(), shapes[0].corners.end());
  EXPECT_EQ(corners.count(1) + corners.count(2), 1u) << "one tip of the first";
  EXPECT_EQ(corners.count(5) + corners.count(6), 1u) << "one tip of the second";
  EXPECT_LT(shapes[0].mismatch_m2, 0.25f * shapes[1].mismatch_m2) << "merge_corners spans both and the gap";
}

TEST(PairShapes, AreDistinctAscendingAndTheLastIsThePapers) {
  const Foliage foliage = test::random_quads(2, 11);
  const std::vector<PairShape> shapes = shapes_of(foliage.quads[0], foliage.quads[1], 100);
  EXPECT_EQ(shapes.back().corners, merge_corners(foliage.quads[0], foliage.quads[1]));
  for (std::size_t i = 0; i + 2 < shapes.size(); ++i) EXPECT_LE(shapes[i].mismatch_m2, shapes[i + 1].mismatch_m2) << i;
  std::set<PairCorners> distinct;
  for (std::size_t i = 0; i + 1 < shapes.size(); ++i) distinct.insert(shapes[i].corners);
  EXPECT_EQ(distinct.size(), shapes.size() - 1);
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
  double sum = 0.0;
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
    sum += (differing + std::abs(excess)) * cell * cell;
  }
  return sum / 6;
}

TEST(PairShapes, MismatchIsThatOfAFinerGridWithinItsCells) {
  const Foliage foliage = test::random_quads(12, 12);
  for (std::size_t i = 0; i < 12; i += 2) {
    const Quad &first = foliage.quads[i], &second = foliage.quads[i + 1];
    for (const PairShape& shape : shapes_of(first, second, 8)) {
      const double fine = fine_mismatch(first, second, merged_quad(first, second, shape.corners));
      EXPECT_NEAR(static_cast<double>(shape.mismatch_m2), fine, 0.03 + 0.15 * fine) << i;
    }
  }
}

TEST(PairShapes, LeavesWithoutExtentHaveNoMismatch) {
  const Quad point = test::rectangle({1, 2, 3}, {0, 0, 0}, {0, 0, 0});
  for (const PairShape& shape : shapes_of(point, point, 4)) EXPECT_EQ(shape.mismatch_m2, 0.0f);
}

}  // namespace
}  // namespace coppice::bake
