#include "piece_shape.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace coppice::bake {
namespace {

PieceShape measure(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& indices) {
  Mesh mesh;
  mesh.positions = positions;
  mesh.indices = indices;
  std::vector<std::uint32_t> triangles(indices.size() / 3);
  std::iota(triangles.begin(), triangles.end(), 0u);
  return measure_piece(mesh, triangles);
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
  const std::vector<glm::vec3> octahedron{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const PieceShape ball = measure(octahedron, {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5});
  EXPECT_NEAR(ball.flatness, 1.0 / 3.0, 1e-9);
  EXPECT_NEAR(ball.length_m, 2.0, 1e-9);
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

}  // namespace
}  // namespace coppice::bake
