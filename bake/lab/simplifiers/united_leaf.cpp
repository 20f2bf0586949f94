#include "united_leaf.h"

#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "gltf_write.h"
#include "quad_merge.h"

namespace coppice::bake {
namespace {

std::array<glm::dvec3, 8> corners_of(const Quad& first, const Quad& second) {
  std::array<glm::dvec3, 8> corners{};
  for (std::size_t i = 0; i < 4; ++i) {
    corners[i] = glm::dvec3(first[i]);
    corners[4 + i] = glm::dvec3(second[i]);
  }
  return corners;
}

/// The longest vector between two corners.
glm::dvec3 diameter_of(const std::array<glm::dvec3, 8>& corners) {
  glm::dvec3 longest(0.0);
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = i + 1; j < 8; ++j)
      if (const glm::dvec3 offset = corners[j] - corners[i]; glm::dot(offset, offset) > glm::dot(longest, longest)) longest = offset;
  return longest;
}

glm::dvec3 axis_of(const Quad& quad) {
  return 0.5 * (glm::dvec3(quad[1]) + glm::dvec3(quad[2]) - glm::dvec3(quad[0]) - glm::dvec3(quad[3]));
}

glm::dvec3 side_of(const Quad& quad) {
  return 0.5 * (glm::dvec3(quad[2]) + glm::dvec3(quad[3]) - glm::dvec3(quad[0]) - glm::dvec3(quad[1]));
}

double extent_along(const std::array<glm::dvec3, 8>& corners, const glm::dvec3& axis) {
  double low = glm::dot(corners[0], axis), high = low;
  for (const glm::dvec3& corner : corners) {
    low = std::min(low, glm::dot(corner, axis));
    high = std::max(high, glm::dot(corner, axis));
  }
  return high - low;
}

double similar_length(const Quad& larger, double area) {
  const double long_side = glm::length(axis_of(larger)), short_side = glm::length(side_of(larger));
  const double ratio = short_side > 0.0 ? std::max(long_side, short_side) / std::min(long_side, short_side) : 1.0;
  return std::sqrt(area * (std::isfinite(ratio) ? ratio : 1.0));
}

}  // namespace

std::vector<UnitedLeaf> united_leaves(const Foliage& foliage) {
  std::vector<UnitedLeaf> leaves;
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) leaves.push_back({foliage.quads[leaf], foliage.cards[leaf]});
  return leaves;
}

Level level_of(const std::vector<UnitedLeaf>& leaves, const std::vector<Card>& card_table) {
  Foliage foliage;
  foliage.card_table = card_table;
  for (const UnitedLeaf& leaf : leaves) {
    foliage.quads.push_back(leaf.quad);
    foliage.cards.push_back(leaf.card);
  }
  return Level{foliage_mesh(foliage)};
}

glm::dvec3 quad_normal(const Quad& quad) {
  const glm::dvec3 across = glm::cross(glm::dvec3(quad[2]) - glm::dvec3(quad[0]), glm::dvec3(quad[3]) - glm::dvec3(quad[1]));
  const double length = glm::length(across);
  return length > 0.0 ? across / length : glm::dvec3(0.0);
}

double leaf_angle(const Quad& first, const Quad& second) {
  return 1.0 - std::min(1.0, std::abs(glm::dot(quad_normal(first), quad_normal(second))));
}

double pair_diameter_m(const Quad& first, const Quad& second) {
  return glm::length(diameter_of(corners_of(first, second)));
}

Quad united_rectangle(const Quad& first, const Quad& second, RectangleLength length) {
  const double first_area = quad_area(first), second_area = quad_area(second), area = first_area + second_area;
  if (!(area > 0.0)) return first;
  const glm::dvec3 first_normal = quad_normal(first), second_normal = quad_normal(second);
  const double side = glm::dot(first_normal, second_normal) < 0.0 ? -1.0 : 1.0;
  const glm::dvec3 mean_normal = first_area * first_normal + side * second_area * second_normal;
  const glm::dvec3 normal = glm::length(mean_normal) > 0.0 ? glm::normalize(mean_normal) : glm::dvec3(0, 1, 0);
  const auto corners = corners_of(first, second);
  glm::dvec3 axis = diameter_of(corners);
  axis -= glm::dot(axis, normal) * normal;
  if (!(glm::length(axis) > 0.0)) return first_area < second_area ? second : first;
  axis = glm::normalize(axis);
  if (glm::dot(axis, axis_of(first)) < 0.0) axis = -axis;
  const glm::dvec3 middle = (first_area * quad_centroid(first) + second_area * quad_centroid(second)) / area;
  const double long_m =
      length == RectangleLength::extent ? extent_along(corners, axis) : similar_length(first_area < second_area ? second : first, area);
  const glm::dvec3 half = 0.5 * long_m * axis, across = 0.5 * area / long_m * glm::cross(normal, axis);
  return {glm::vec3(middle - half - across), glm::vec3(middle + half - across), glm::vec3(middle + half + across),
          glm::vec3(middle - half + across)};
}

}  // namespace coppice::bake
