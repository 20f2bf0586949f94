#include "piece_shape.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace coppice::bake {
namespace {

/// Largest eigenvalue of a symmetric matrix, from its characteristic polynomial in Cardano's trigonometric form.
double largest_eigenvalue(const glm::dmat3& m) {
  const double mean = (m[0][0] + m[1][1] + m[2][2]) / 3.0;
  const glm::dmat3 rest = m - mean * glm::dmat3(1.0);
  const double spread = std::sqrt((glm::dot(rest[0], rest[0]) + glm::dot(rest[1], rest[1]) + glm::dot(rest[2], rest[2])) / 6.0);
  if (spread == 0.0) return mean;
  const double half_determinant = glm::determinant(rest / spread) / 2.0;
  return mean + 2.0 * spread * std::cos(std::acos(std::clamp(half_determinant, -1.0, 1.0)) / 3.0);
}

std::vector<glm::vec3> distinct_points(const Mesh& mesh, std::span<const std::uint32_t> triangles) {
  std::vector<glm::vec3> points;
  points.reserve(3 * triangles.size());
  for (const std::uint32_t t : triangles)
    for (std::size_t k = 0; k < 3; ++k) points.push_back(mesh.positions[mesh.indices[3 * std::size_t{t} + k]]);
  const auto less = [](const glm::vec3& a, const glm::vec3& b) { return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z; };
  std::sort(points.begin(), points.end(), less);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

glm::dvec3 farthest_from(const glm::dvec3& from, const std::vector<glm::vec3>& points) {
  return *std::ranges::max_element(points, {}, [&](const glm::vec3& point) { return glm::distance(from, glm::dvec3(point)); });
}

}  // namespace

PieceShape measure_piece(const Mesh& mesh, std::span<const std::uint32_t> triangles) {
  PieceShape shape;
  const std::vector<glm::vec3> points = distinct_points(mesh, triangles);
  shape.point_count = static_cast<std::uint32_t>(points.size());
  glm::dvec3 sum(0.0);
  for (const glm::vec3& point : points) sum += glm::dvec3(point);
  const glm::dvec3 one_end = farthest_from(sum / static_cast<double>(points.size()), points), other_end = farthest_from(one_end, points);
  shape.length_m = glm::distance(one_end, other_end);
  for (const glm::vec3& point : points)
    shape.width_m = std::max(shape.width_m, 2.0 * glm::length(glm::cross(glm::dvec3(point) - one_end, other_end - one_end)));
  shape.width_m = shape.length_m > 0.0 ? shape.width_m / shape.length_m : 0.0;

  glm::dmat3 normals(0.0);
  glm::dvec3 doubled_sum(0.0);
  for (const std::uint32_t t : triangles) {
    const std::uint32_t* corners = &mesh.indices[3 * std::size_t{t}];
    const glm::dvec3 a(mesh.positions[corners[0]]), b(mesh.positions[corners[1]]), c(mesh.positions[corners[2]]);
    const glm::dvec3 doubled = glm::cross(b - a, c - a);
    const double length = glm::length(doubled);
    if (length == 0.0) continue;
    shape.area_m2 += 0.5 * length;
    doubled_sum += doubled;
    normals += glm::outerProduct(doubled, doubled * (0.5 / length));
  }
  if (shape.area_m2 > 0.0)
    shape.flatness = std::max(largest_eigenvalue(normals / shape.area_m2), std::min(0.6 * glm::length(doubled_sum) / shape.area_m2, 1.0));
  return shape;
}

}  // namespace coppice::bake
