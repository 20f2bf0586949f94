#include "leaf_reach.h"

#include <algorithm>
#include <set>

#include <glm/geometric.hpp>

namespace coppice::bake {
namespace {

double squared_distance_to_segment(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 along = b - a, from_a = point - a;
  const double length2 = glm::dot(along, along);
  const double t = length2 > 0.0 ? std::clamp(glm::dot(from_a, along) / length2, 0.0, 1.0) : 0.0;
  const glm::dvec3 offset = from_a - along * t;
  return glm::dot(offset, offset);
}

double squared_distance_to_triangle(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double length2 = glm::dot(normal, normal);
  const auto inside = [&](const glm::dvec3& from, const glm::dvec3& to) {
    return glm::dot(glm::cross(to - from, point - from), normal) >= 0.0;
  };
  if (length2 > 0.0 && inside(a, b) && inside(b, c) && inside(c, a)) {
    const double height = glm::dot(point - a, normal);
    return height * height / length2;
  }
  return std::min(
      {squared_distance_to_segment(point, a, b), squared_distance_to_segment(point, b, c), squared_distance_to_segment(point, c, a)});
}

}  // namespace

ReachPoints merged_reach_points(const ReachPoints& first, const ReachPoints& second) {
  static const std::array<glm::vec3, 7> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}}};
  ReachPoints all = first;
  all.insert(all.end(), second.begin(), second.end());
  if (all.size() <= 2 * axes.size()) return all;
  std::set<ReachPoints::iterator> outermost;
  for (const glm::vec3& axis : axes) {
    const auto along = [&](const glm::vec3& point) { return glm::dot(axis, point); };
    outermost.insert({std::ranges::min_element(all, {}, along), std::ranges::max_element(all, {}, along)});
  }
  ReachPoints result;
  for (const auto point : outermost) result.push_back(*point);
  return result;
}

double squared_reach(const ReachPoints& points, const Quad& quad) {
  double farthest = 0.0;
  for (const glm::vec3& point : points)
    farthest = std::max(farthest, std::min(squared_distance_to_triangle(point, quad[0], quad[1], quad[2]),
                                           squared_distance_to_triangle(point, quad[0], quad[2], quad[3])));
  return farthest;
}

}  // namespace coppice::bake
