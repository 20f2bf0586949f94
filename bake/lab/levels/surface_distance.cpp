#include "surface_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "parallel_for.h"

namespace coppice::bake {
namespace {

using Triangle = std::array<glm::dvec3, 3>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kTrianglesPerLeaf = 4;
constexpr std::uint32_t kMaxDepth = 48;

Triangle triangle_of(const Mesh& mesh, std::size_t triangle) {
  const std::uint32_t* indices = mesh.indices.data() + 3 * triangle;
  return {mesh.positions[indices[0]], mesh.positions[indices[1]], mesh.positions[indices[2]]};
}

double area_of(const Triangle& t) {
  return 0.5 * glm::length(glm::cross(t[1] - t[0], t[2] - t[0]));
}

glm::dvec3 middle_of(const Triangle& t) {
  return (t[0] + t[1] + t[2]) / 3.0;
}

double squared(const glm::dvec3& v) {
  return glm::dot(v, v);
}

double squared_distance_to_segment(const glm::dvec3& point, const glm::dvec3& from, const glm::dvec3& to) {
  const glm::dvec3 along = to - from;
  const double length_squared = squared(along);
  const double place = length_squared > 0.0 ? std::clamp(glm::dot(point - from, along) / length_squared, 0.0, 1.0) : 0.0;
  return squared(point - (from + place * along));
}

/// Maximum and sum of the distances from a run of points.
struct Partial {
  double max_m = 0.0, sum_m = 0.0;
};

/// Works in blocks of a fixed size, which are added up in order: the same sum for any number of threads.
Partial distances(const std::vector<glm::dvec3>& points, const TriangleTree& to) {
  constexpr std::size_t kBlock = 256;
  std::vector<Partial> blocks((points.size() + kBlock - 1) / kBlock);
  parallel_for(blocks.size(), [&](std::size_t block) {
    for (std::size_t i = block * kBlock; i < std::min(points.size(), (block + 1) * kBlock); ++i) {
      const double distance_m = std::sqrt(to.squared_distance(points[i]));
      blocks[block].max_m = std::max(blocks[block].max_m, distance_m);
      blocks[block].sum_m += distance_m;
    }
  });
  Partial all;
  for (const Partial& block : blocks) {
    all.max_m = std::max(all.max_m, block.max_m);
    all.sum_m += block.sum_m;
  }
  return all;
}

}  // namespace

double squared_distance_to_triangle(const glm::dvec3& point, const Triangle& t) {
  const glm::dvec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double normal_squared = squared(normal);
  const auto inside_of = [&](const glm::dvec3& from, const glm::dvec3& to) {
    return glm::dot(glm::cross(to - from, point - from), normal) >= 0.0;
  };
  // Above the face the distance is to its plane, elsewhere to an edge.
  if (normal_squared > 0.0 && inside_of(t[0], t[1]) && inside_of(t[1], t[2]) && inside_of(t[2], t[0])) {
    const double height = glm::dot(point - t[0], normal);
    return height * height / normal_squared;
  }
  return std::min({squared_distance_to_segment(point, t[0], t[1]), squared_distance_to_segment(point, t[1], t[2]),
                   squared_distance_to_segment(point, t[2], t[0])});
}

TriangleTree::TriangleTree(const Mesh& mesh) {
  const auto triangle_count = static_cast<std::uint32_t>(mesh.indices.size() / 3);
  if (triangle_count == 0) return;
  std::vector<Triangle> source;
  source.reserve(triangle_count);
  for (std::uint32_t i = 0; i < triangle_count; ++i) source.push_back(triangle_of(mesh, i));
  std::vector<std::uint32_t> order(triangle_count);
  std::iota(order.begin(), order.end(), 0u);
  nodes_.push_back({{}, 0, triangle_count});
  split(0, 0, order, source);
  triangles_.reserve(triangle_count);
  for (const std::uint32_t triangle : order) triangles_.push_back(source[triangle]);
}

void TriangleTree::split(std::uint32_t node, std::uint32_t depth, std::vector<std::uint32_t>& order, const std::vector<Triangle>& source) {
  const std::uint32_t first = nodes_[node].first, count = nodes_[node].count;
  Box box{glm::dvec3(kInfinite), glm::dvec3(-kInfinite)}, middles = box;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const Triangle& triangle = source[order[i]];
    for (const glm::dvec3& corner : triangle) {
      box.low = glm::min(box.low, corner);
      box.high = glm::max(box.high, corner);
    }
    middles.low = glm::min(middles.low, middle_of(triangle));
    middles.high = glm::max(middles.high, middle_of(triangle));
  }
  nodes_[node].box = box;
  if (count <= kTrianglesPerLeaf || depth >= kMaxDepth) return;

  const glm::dvec3 extent = middles.high - middles.low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::uint32_t half = count / 2;
  const auto begin = order.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    const double at_a = middle_of(source[a])[axis], at_b = middle_of(source[b])[axis];
    return at_a != at_b ? at_a < at_b : a < b;
  });
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, first, half});
  nodes_.push_back({{}, first + half, count - half});
  nodes_[node].first = child;
  nodes_[node].count = 0;
  split(child, depth + 1, order, source);
  split(child + 1, depth + 1, order, source);
}

double TriangleTree::squared_distance_to_box(const glm::dvec3& point, const Box& box) {
  return squared(glm::max(glm::max(box.low - point, point - box.high), glm::dvec3(0.0)));
}

double TriangleTree::squared_distance(const glm::dvec3& point) const {
  double best = kInfinite;
  if (!nodes_.empty()) lower(best, point, 0, squared_distance_to_box(point, nodes_[0].box));
  return best;
}

void TriangleTree::lower(double& best, const glm::dvec3& point, std::uint32_t index, double box_distance) const {
  if (box_distance >= best) return;
  const Node& node = nodes_[index];
  if (node.count > 0) {
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      best = std::min(best, squared_distance_to_triangle(point, triangles_[i]));
    return;
  }
  std::pair near{squared_distance_to_box(point, nodes_[node.first].box), node.first};
  std::pair far{squared_distance_to_box(point, nodes_[node.first + 1].box), node.first + 1};
  if (far.first < near.first) std::swap(near, far);
  lower(best, point, near.second, near.first);
  lower(best, point, far.second, far.first);
}

SurfaceSamples sample_surface(const Mesh& mesh, std::uint32_t point_count) {
  SurfaceSamples samples;
  std::vector<bool> used(mesh.positions.size(), false);
  for (const std::uint32_t index : mesh.indices) used[index] = true;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) samples.vertices.emplace_back(mesh.positions[i]);

  const double area = surface_area_m2(mesh);
  if (!(area > 0.0)) return samples;
  // Equal steps along all triangles' area select a triangle; within it the R2 sequence (Roberts 2018) selects evenly spread points.
  constexpr double kStepU = 0.7548776662466927, kStepV = 0.5698402909980532;
  double area_before = 0.0;
  std::uint32_t taken = 0;
  for (std::size_t t = 0; t < mesh.indices.size() / 3 && taken < point_count; ++t) {
    const Triangle triangle = triangle_of(mesh, t);
    area_before += area_of(triangle);
    for (; taken < point_count && (taken + 0.5) / point_count * area <= area_before; ++taken) {
      double u = std::fmod(0.5 + kStepU * (taken + 1.0), 1.0), v = std::fmod(0.5 + kStepV * (taken + 1.0), 1.0);
      if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
      samples.points.push_back(triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]));
    }
  }
  return samples;
}

SurfaceDistance distance_to_surface(const SurfaceSamples& from, const TriangleTree& to) {
  if (from.vertices.empty()) return {kInfinite, kInfinite};
  const Partial vertices = distances(from.vertices, to), points = distances(from.points, to);
  SurfaceDistance distance;
  distance.max_m = std::max(vertices.max_m, points.max_m);
  distance.mean_m = from.points.empty() ? vertices.sum_m / static_cast<double>(from.vertices.size())
                                        : points.sum_m / static_cast<double>(from.points.size());
  return distance;
}

SurfaceDistance symmetric_distance(const SurfaceDistance& forward, const SurfaceDistance& backward) {
  return {std::max(forward.max_m, backward.max_m), std::max(forward.mean_m, backward.mean_m)};
}

double surface_area_m2(const Mesh& mesh) {
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.indices.size() / 3; ++t) area += area_of(triangle_of(mesh, t));
  return area;
}

}  // namespace coppice::bake
