#include "quad_merge.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace coppice::bake {
namespace {

/// The first of the unused vertices that maximises the summed distance to the chosen ones.
std::uint8_t farthest_from(const PairVertices& points, std::span<const std::uint8_t> chosen) {
  std::uint8_t best = 0;
  double best_sum = -1.0;
  for (std::uint8_t i = 0; i < 8; ++i) {
    if (std::ranges::find(chosen, i) != chosen.end()) continue;
    double sum = 0.0;
    for (const std::uint8_t other : chosen) sum += glm::distance(points[i], points[other]);
    if (sum > best_sum) best = i, best_sum = sum;
  }
  return best;
}

}  // namespace

PairVertices pair_vertices(const Quad& first, const Quad& second) {
  PairVertices points;
  std::ranges::copy(second, std::ranges::copy(first, points.begin()).out);
  return points;
}

double quad_area(const Quad& quad) {
  const glm::dvec3 a = quad[0], b = quad[1], c = quad[2], d = quad[3];
  return 0.5 * (glm::length(glm::cross(b - a, c - a)) + glm::length(glm::cross(c - a, d - a)));
}

glm::dvec3 quad_centroid(const Quad& quad) {
  return (glm::dvec3(quad[0]) + glm::dvec3(quad[1]) + glm::dvec3(quad[2]) + glm::dvec3(quad[3])) * 0.25;
}

PairCorners merge_corners(const Quad& first, const Quad& second) {
  const PairVertices points = pair_vertices(first, second);
  PairCorners chosen{0, 1, 0, 0};
  double longest = -1.0;
  for (std::uint8_t i = 0; i < 8; ++i) {
    for (std::uint8_t j = static_cast<std::uint8_t>(i + 1); j < 8; ++j) {
      const double length = glm::distance(points[i], points[j]);
      if (length <= longest) continue;
      longest = length;
      chosen[0] = i;
      chosen[1] = j;
    }
  }
  chosen[2] = farthest_from(points, std::span(chosen).first(2));
  chosen[3] = farthest_from(points, std::span(chosen).first(3));
  return {chosen[0], chosen[2], chosen[1], chosen[3]};
}

Quad merged_quad(const Quad& first, const Quad& second, const PairCorners& corners) {
  Quad quad;
  for (std::size_t i = 0; i < 4; ++i) quad[i] = corners[i] < 4 ? first[corners[i]] : second[corners[i] - 4u];
  return quad;
}

std::uint32_t merged_card(const Quad& first, std::uint32_t first_card, const Quad& second, std::uint32_t second_card) {
  return quad_area(second) > quad_area(first) ? second_card : first_card;
}

}  // namespace coppice::bake
