#include "piece_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace coppice::bake {
namespace {

/// Largest eigenvalue of a symmetric matrix, by Cardano's trigonometric solution of its characteristic polynomial.
double largest_eigenvalue(const glm::dmat3& m) {
  const double mean = (m[0][0] + m[1][1] + m[2][2]) / 3.0;
  const glm::dmat3 rest = m - mean * glm::dmat3(1.0);
  const double spread = std::sqrt((glm::dot(rest[0], rest[0]) + glm::dot(rest[1], rest[1]) + glm::dot(rest[2], rest[2])) / 6.0);
  if (spread == 0.0) return mean;
  const double half_determinant = glm::determinant(rest / spread) / 2.0;
  return mean + 2.0 * spread * std::cos(std::acos(std::clamp(half_determinant, -1.0, 1.0)) / 3.0);
}

bool is_before(const glm::vec3& a, const glm::vec3& b) {
  return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// Distinct positions, sorted by is_before.
std::vector<glm::vec3> distinct_points(const Mesh& mesh, std::span<const std::uint32_t> triangles) {
  std::vector<glm::vec3> points;
  points.reserve(3 * triangles.size());
  for (const std::uint32_t t : triangles)
    for (std::size_t k = 0; k < 3; ++k) points.push_back(mesh.positions[mesh.indices[3 * std::size_t{t} + k]]);
  std::sort(points.begin(), points.end(), is_before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

glm::dvec3 farthest_from(const glm::dvec3& from, const std::vector<glm::vec3>& points) {
  return *std::ranges::max_element(points, {}, [&](const glm::vec3& point) { return glm::distance(from, glm::dvec3(point)); });
}

/// A triangle or an edge, given by its points in rising order.
template <std::size_t kCorners>
using PointSet = std::array<std::uint32_t, kCorners>;

/// The triangles as numbers of points: without collapsed ones, and one of those that are the same in either winding.
std::vector<PointSet<3>> distinct_triangles(const Mesh& mesh, std::span<const std::uint32_t> triangles,
                                            const std::vector<glm::vec3>& points) {
  std::vector<PointSet<3>> distinct;
  distinct.reserve(triangles.size());
  for (const std::uint32_t t : triangles) {
    PointSet<3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3& position = mesh.positions[mesh.indices[3 * std::size_t{t} + k]];
      corners[k] = static_cast<std::uint32_t>(std::lower_bound(points.begin(), points.end(), position, is_before) - points.begin());
    }
    std::ranges::sort(corners);
    if (corners[0] != corners[1] && corners[1] != corners[2]) distinct.push_back(corners);
  }
  std::ranges::sort(distinct);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  return distinct;
}

/// Lists each edge once for each of its triangles; equal edges are neighbours.
std::vector<PointSet<2>> sorted_edges(const std::vector<PointSet<3>>& triangles) {
  std::vector<PointSet<2>> edges;
  edges.reserve(3 * triangles.size());
  for (const auto& [a, b, c] : triangles) edges.insert(edges.end(), {{a, b}, {a, c}, {b, c}});
  std::ranges::sort(edges);
  return edges;
}

/// Where a surface ends: edges that have one triangle.
struct Rim {
  double length_m = 0.0, area_m2 = 0.0;  ///< area: one side's
  bool is_sheet = false;                 ///< a sheet without holes, or closed: no tube or ring
  /// Square of the rim's length over the area, which bending a sheet does not change. At least 4 pi if the surface can be unrolled flat
  /// without holes, 2 pi for half a ball, (girth / length) for a tube that is closed at one end.
  [[nodiscard]] double openness() const { return area_m2 > 0.0 ? length_m * length_m / area_m2 : 0.0; }
};

Rim measure_rim(const Mesh& mesh, std::span<const std::uint32_t> triangles, const std::vector<glm::vec3>& points) {
  const std::vector<PointSet<3>> distinct = distinct_triangles(mesh, triangles, points);
  const std::vector<PointSet<2>> edges = sorted_edges(distinct);
  Rim rim;
  std::size_t edge_count = 0;
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    while (last < edges.size() && edges[last] == edges[first]) ++last;
    ++edge_count;
    if (last - first == 1) rim.length_m += glm::distance(glm::dvec3(points[edges[first][0]]), glm::dvec3(points[edges[first][1]]));
  }
  for (const auto& [a, b, c] : distinct)
    rim.area_m2 += 0.5 * glm::length(glm::cross(glm::dvec3(points[b] - points[a]), glm::dvec3(points[c] - points[a])));
  // Euler's characteristic is 1 for a sheet without holes, 0 for a tube.
  rim.is_sheet = points.size() + distinct.size() >= edge_count + 1;
  return rim;
}

constexpr double kHalfBall = 2.0 * std::numbers::pi;

/// Flatness that a sheet has, however it is bent.
double bent_flatness(double openness) {
  constexpr double kSheetFlatness = 0.8, kSheet = 4.0 * std::numbers::pi;
  // Coarse triangles cut corners of a rim that is nearly a circle.
  return kSheetFlatness * std::clamp((openness - kHalfBall) / (0.98 * kSheet - kHalfBall), 0.0, 1.0);
}

/// area_m2  all triangles
double bulk_of(const Rim& rim, double volume_m3, double area_m2) {
  constexpr double kOpen = 1.5 * kHalfBall;
  if (rim.openness() >= kOpen) return 0.0;
  const double cubed_m6 = area_m2 * area_m2 * area_m2;
  return cubed_m6 > 0.0 ? std::min(36.0 * std::numbers::pi * volume_m3 * volume_m3 / cubed_m6, 1.0) : 0.0;
}

}  // namespace

PieceShape measure_piece(const Mesh& mesh, std::span<const std::uint32_t> triangles) {
  PieceShape shape;
  const std::vector<glm::vec3> points = distinct_points(mesh, triangles);
  shape.point_count = static_cast<std::uint32_t>(points.size());
  const auto [low, high] = std::ranges::minmax(points, {}, [](const glm::vec3& point) { return point.y; });
  shape.low_m = static_cast<double>(low.y);
  shape.high_m = static_cast<double>(high.y);
  glm::dvec3 sum(0.0);
  for (const glm::vec3& point : points) sum += glm::dvec3(point);
  const glm::dvec3 middle = sum / static_cast<double>(points.size());
  const glm::dvec3 one_end = farthest_from(middle, points), other_end = farthest_from(one_end, points);
  shape.length_m = glm::distance(one_end, other_end);
  for (const glm::vec3& point : points)
    shape.width_m = std::max(shape.width_m, 2.0 * glm::length(glm::cross(glm::dvec3(point) - one_end, other_end - one_end)));
  shape.width_m = shape.length_m > 0.0 ? shape.width_m / shape.length_m : 0.0;

  const Rim rim = measure_rim(mesh, triangles, points);
  double volume_m3 = 0.0;
  glm::dmat3 normals(0.0);
  glm::dvec3 doubled_sum(0.0);
  for (const std::uint32_t t : triangles) {
    const std::uint32_t* corners = &mesh.indices[3 * std::size_t{t}];
    const glm::dvec3 a(mesh.positions[corners[0]]), b(mesh.positions[corners[1]]), c(mesh.positions[corners[2]]);
    const glm::dvec3 doubled = glm::cross(b - a, c - a);
    const double length = glm::length(doubled);
    if (length == 0.0) continue;
    shape.area_m2 += 0.5 * length;
    volume_m3 += glm::dot(a - middle, doubled) / 6.0;
    doubled_sum += doubled;
    normals += glm::outerProduct(doubled, doubled * (0.5 / length));
  }
  if (shape.area_m2 > 0.0)
    shape.flatness = std::max({largest_eigenvalue(normals / shape.area_m2), std::min(0.6 * glm::length(doubled_sum) / shape.area_m2, 1.0),
                               bent_flatness(rim.is_sheet ? rim.openness() : 0.0)});
  shape.bulk = bulk_of(rim, volume_m3, shape.area_m2);
  return shape;
}

}  // namespace coppice::bake
