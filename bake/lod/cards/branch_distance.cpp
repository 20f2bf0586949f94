#include "branch_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "nearest_point.h"

namespace coppice::bake {
namespace {

// Edges longer than this share of the wood's box get extra points: the sides of tubes have vertices at their ends only.
constexpr double kSpacing = 1.0 / 512.0;
constexpr std::uint32_t kMaxPointsPerEdge = 256;
constexpr std::size_t kMaxPoints = std::size_t{1} << 22;

std::pair<glm::vec3, glm::vec3> box(const std::vector<glm::vec3>& points) {
  glm::vec3 low = points.front(), high = points.front();
  for (const glm::vec3& point : points) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  return {low, high};
}

std::vector<glm::vec3> branch_points(const Mesh& wood) {
  const auto [low, high] = box(wood.positions);
  const double spacing_m = glm::distance(glm::dvec3(low), glm::dvec3(high)) * kSpacing;
  std::vector<glm::vec3> points = wood.positions;
  if (spacing_m <= 0.0) return points;
  for (std::size_t i = 0; i < wood.indices.size() && points.size() < kMaxPoints; ++i) {
    const glm::vec3& from = wood.positions[wood.indices[i]];
    const glm::vec3& to = wood.positions[wood.indices[i % 3 == 2 ? i - 2 : i + 1]];
    const double steps = std::ceil(glm::distance(glm::dvec3(from), glm::dvec3(to)) / spacing_m);
    const auto step_count = static_cast<std::uint32_t>(std::min(steps, double{kMaxPointsPerEdge}));
    for (std::uint32_t step = 1; step < step_count; ++step)
      points.push_back(glm::mix(from, to, static_cast<float>(step) / static_cast<float>(step_count)));
  }
  return points;
}

}  // namespace

struct BranchDistance::Tree {
  NearestPoint<float> nearest;
  explicit Tree(std::vector<glm::vec3> points) : nearest(std::move(points), 16) {}
};

BranchDistance::BranchDistance(const Plant& plant) {
  if (!plant.wood.indices.empty()) {
    tree_ = std::make_unique<Tree>(branch_points(plant.wood));
  } else if (!plant.foliage.positions.empty()) {
    const auto [low, high] = box(plant.foliage.positions);
    axis_ = 0.5f * (low + high);
  }
}

BranchDistance::~BranchDistance() = default;

glm::vec3 BranchDistance::nearest_point(const glm::vec3& point) const {
  if (!tree_) return {axis_.x, point.y, axis_.z};
  return tree_->nearest.point(tree_->nearest.to(point));
}

float BranchDistance::distance_m(const glm::vec3& point) const {
  return glm::distance(point, nearest_point(point));
}

}  // namespace coppice::bake
