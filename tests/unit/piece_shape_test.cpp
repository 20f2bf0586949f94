#include "piece_shape.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace coppice::bake::piece_shape_test {

PieceShape measure(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& indices) {
  Mesh mesh;
  mesh.positions = positions;
  mesh.indices = indices;
  std::vector<std::uint32_t> triangles(indices.size() / 3);
  std::iota(triangles.begin(), triangles.end(), 0u);
  return measure_piece(mesh, triangles);
}

PieceShape octahedron() {
  return measure({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                 {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5});
}

TEST(PieceShape, ACard) {
  const PieceShape shape = measure({{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {0, 3, 0}}, {0, 1, 2, 0, 2, 3});
  EXPECT_EQ(shape.point_count, 4u);
  EXPECT_NEAR(shape.length_m, 5.0, 1e-6);
  EXPECT_NEAR(shape.width_m, 2.0 * 12.0 / 5.0, 1e-6);
  EXPECT_NEAR(shape.area_m2, 12.0, 1e-6);
  EXPECT_NEAR(shape.flatness, 1.0, 1e-9);
}

TEST(PieceShape, BothSidesOfACardAreAsFlat) {
  const PieceShape shape = measure({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2, 0, 2, 1});
  EXPECT_NEAR(shape.flatness, 1.0, 1e-9);
  EXPECT_NEAR(shape.area_m2, 1.0, 1e-6);
}

TEST(PieceShape, ALeafFoldedByARightAngle) {
  const PieceShape shape = measure({{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 0, 1}}, {0, 1, 2, 0, 3, 1});
  // Normals +z and +y: mean of length sqrt(1/2).
  EXPECT_NEAR(shape.flatness, 1.2 * std::sqrt(0.5), 1e-9);
}

TEST(PieceShape, AnOpenTubeIsHalfFlatAndABallAThird) {
  std::vector<glm::vec3> ring;
  std::vector<std::uint32_t> indices;
  constexpr std::uint32_t kSides = 12;
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    for (const float height : {0.0f, 10.0f}) ring.emplace_back(std::cos(angle), height, std::sin(angle));
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kSides);
    indices.insert(indices.end(), {a, a + 1, b, b, a + 1, b + 1});
  }
  EXPECT_NEAR(measure(ring, indices).flatness, 0.5, 1e-6);
  const PieceShape ball = octahedron();
  EXPECT_NEAR(ball.flatness, 1.0 / 3.0, 1e-9);
  EXPECT_NEAR(ball.length_m, 2.0, 1e-9);
}

/// A grid of columns x rows quads over [0, 1]^2, each point where `place` puts it.
template <class Place>
PieceShape measure_grid(std::uint32_t columns, std::uint32_t rows, bool two_sided, const Place& place) {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t y = 0; y <= rows; ++y)
    for (std::uint32_t x = 0; x <= columns; ++x) positions.push_back(place(double{1} * x / columns, double{1} * y / rows));
  for (std::uint32_t y = 0; y < rows; ++y)
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t a = y * (columns + 1) + x, b = a + 1, c = a + columns + 1, d = c + 1;
      indices.insert(indices.end(), {a, b, d, a, d, c});
      if (two_sided) indices.insert(indices.end(), {b, a, d, d, a, c});
    }
  return measure(positions, indices);
}

TEST(PieceShape, ABladeThatHangsOverIsASheet) {
  const auto arch = [](double x, double y) { return glm::vec3(0.05 * x, std::sin(std::numbers::pi * y), -std::cos(std::numbers::pi * y)); };
  EXPECT_NEAR(measure_grid(1, 16, false, arch).flatness, 0.8, 1e-9);
  EXPECT_NEAR(measure_grid(2, 16, true, arch).flatness, 0.8, 1e-9);
}

TEST(PieceShape, ATwistedBladeIsASheet) {
  const auto twist = [](double x, double y) {
    const double angle = 2.0 * std::numbers::pi * y;
    return glm::vec3((x - 0.5) * std::cos(angle), 6.0 * y, (x - 0.5) * std::sin(angle));
  };
  EXPECT_NEAR(measure_grid(2, 24, false, twist).flatness, 0.8, 1e-9);
}

TEST(PieceShape, ARodWithATipIsNoSheet) {
  // Open below, closed above: a sheet by its topology, with a short rim.
  const auto rod = [](double x, double y) {
    const double angle = 2.0 * std::numbers::pi * std::floor(x * 8.0 + 0.5) / 8.0, radius = y > 0.99 ? 0.0 : 0.1;
    return glm::vec3(radius * (x > 0.99 ? 1.0 : std::cos(angle)), 2.0 * y, radius * (x > 0.99 ? 0.0 : std::sin(angle)));
  };
  EXPECT_LT(measure_grid(8, 4, false, rod).flatness, 0.6);
}

TEST(PieceShape, AShortRingIsNoSheet) {
  // Its two rims are longer than a sheet's.
  const auto ring = [](double x, double y) {
    const double angle = 2.0 * std::numbers::pi * x;
    return glm::vec3(x > 0.99 ? 1.0 : std::cos(angle), 0.1 * y, x > 0.99 ? 0.0 : std::sin(angle));
  };
  EXPECT_NEAR(measure_grid(12, 1, false, ring).flatness, 0.5, 0.01);
}

TEST(PieceShape, ABowlIsNoSheet) {
  const auto bowl = [](double x, double y) {
    const double angle = 2.0 * std::numbers::pi * x, height = 0.5 * std::numbers::pi * y;
    const double radius = y > 0.0 ? std::sin(height) : 0.0;
    return glm::vec3(radius * (x > 0.99 ? 1.0 : std::cos(angle)), 1.0 - std::cos(height), radius * (x > 0.99 ? 0.0 : std::sin(angle)));
  };
  EXPECT_LT(measure_grid(24, 8, false, bowl).flatness, 0.65);
}

const std::vector<glm::vec3> kCubeCorners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
const std::vector<std::uint32_t> kFiveSides{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

TEST(PieceShape, BulkOfBodies) {
  std::vector<std::uint32_t> cube = kFiveSides;
  cube.insert(cube.end(), {2, 6, 3, 3, 6, 7});
  EXPECT_NEAR(measure(kCubeCorners, cube).bulk, std::numbers::pi / 6.0, 1e-6);
  // Five sixths of the volume, seen from the middle, and of the area.
  EXPECT_NEAR(measure(kCubeCorners, kFiveSides).bulk, std::numbers::pi / 6.0 * 6.0 / 5.0, 1e-6) << "open at one side";
  EXPECT_NEAR(octahedron().bulk, std::numbers::pi / (3.0 * std::sqrt(3.0)), 1e-6);
}

TEST(PieceShape, SheetsHaveNoBulk) {
  EXPECT_EQ(measure({{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {0, 3, 0}}, {0, 1, 2, 0, 2, 3}).bulk, 0.0);
  const auto arch = [](double x, double y) { return glm::vec3(x, 4.0 * std::sin(2.0 * y), 4.0 * std::cos(2.0 * y)); };
  EXPECT_EQ(measure_grid(2, 12, false, arch).bulk, 0.0);
  // A closed lens, ten times as wide as thick.
  const PieceShape lens = measure({{-5, 0, 0}, {0, 0, 2}, {5, 0, 0}, {0, 0, -2}, {0, 0.2f, 0}, {0, -0.2f, 0}},
                                  {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5});
  EXPECT_GT(lens.bulk, 0.0);
  EXPECT_LT(lens.bulk, 0.02);
}

TEST(PieceShape, WhatHasNoArea) {
  const PieceShape line = measure({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {0, 1, 2});
  EXPECT_EQ(line.area_m2, 0.0);
  EXPECT_EQ(line.flatness, 0.0);
  EXPECT_EQ(line.length_m, 2.0);
  EXPECT_EQ(line.width_m, 0.0);
  const PieceShape point = measure({{3, 3, 3}, {3, 3, 3}, {3, 3, 3}}, {0, 1, 2});
  EXPECT_EQ(point.point_count, 1u);
  EXPECT_EQ(point.length_m, 0.0);
  EXPECT_EQ(point.width_m, 0.0);
}

}  // namespace coppice::bake::piece_shape_test
