#include "fsa.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include <glm/geometric.hpp>

#include "collapse_geometric.h"
#include "quad_merge.h"
#include "united_leaf.h"

namespace coppice::bake {
namespace {

/// Orders four points so that the two that are farthest apart are opposite.
Quad ring_of(const std::array<glm::vec3, 4>& points) {
  std::size_t from = 0, to = 1;
  float longest = -1.0f;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      if (const float length = glm::distance(points[i], points[j]); length > longest) {
        longest = length;
        from = i;
        to = j;
      }
  std::array<std::size_t, 2> rest{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (i != from && i != to) rest[count++] = i;
  return {points[from], points[rest[0]], points[to], points[rest[1]]};
}

enum class Shape { farthest, area };

UnionRules<UnitedLeaf> rules(double angle_weight, Shape shape, double leaf_size_m) {
  UnionRules<UnitedLeaf> made;
  made.cost = [=](const UnitedLeaf& a, const UnitedLeaf& b) { return fsa_error(a.quad, b.quad, angle_weight, leaf_size_m); };
  made.unite = [shape](const UnitedLeaf& a, const UnitedLeaf& b) {
    const Quad quad =
        shape == Shape::farthest ? merged_quad(a.quad, b.quad, merge_corners(a.quad, b.quad)) : area_keeping_quad(a.quad, b.quad);
    return UnitedLeaf{quad, merged_card(a.quad, a.card, b.quad, b.card)};
  };
  made.middle = [](const UnitedLeaf& leaf) { return quad_centroid(leaf.quad); };
  return made;
}

}  // namespace

double fsa_error(const Quad& first, const Quad& second, double angle_weight, double leaf_size_m) {
  const double distance_m = glm::distance(quad_centroid(first), quad_centroid(second));
  const double near = leaf_size_m > 0.0 ? distance_m / leaf_size_m : 0.0;
  return angle_weight * leaf_angle(first, second) + (1.0 - angle_weight) * near;
}

Quad area_keeping_quad(const Quad& first, const Quad& second) {
  const double first_area = quad_area(first), second_area = quad_area(second), area = first_area + second_area;
  if (!(area > 0.0)) return first;
  const glm::dvec3 middle = (first_area * quad_centroid(first) + second_area * quad_centroid(second)) / area;
  Quad best = first;
  double lowest = std::numeric_limits<double>::infinity();
  for (unsigned chosen = 0; chosen < 256; ++chosen) {
    if (std::popcount(chosen) != 4) continue;
    std::array<glm::vec3, 4> points{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < 8; ++i)
      if ((chosen >> i & 1u) != 0) points[count++] = i < 4 ? first[i] : second[i - 4];
    const Quad quad = ring_of(points);
    const double error = std::abs(quad_area(quad) - area) / area + glm::distance(quad_centroid(quad), middle) / std::sqrt(area);
    if (!(error < lowest)) continue;
    lowest = error;
    best = quad;
  }
  return best;
}

std::vector<Variant> simplify_fsa(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts) {
  const double leaf_size_m = mean_leaf_size_m(foliage);
  std::vector<Variant> variants;
  for (const Shape shape : {Shape::farthest, Shape::area})
    for (const double angle_weight : {0.1, 0.25, 0.5, 0.75, 0.9}) {
      Variant variant;
      variant.parameters =
          std::string(shape == Shape::farthest ? "farthest" : "area") + ", angle " + std::to_string(angle_weight).substr(0, 4);
      const GreedyUnion<UnitedLeaf> united(foliage, united_leaves(foliage), rules(angle_weight, shape, leaf_size_m));
      for (const auto& leaves : unite_to(united, leaf_counts)) variant.levels.push_back(level_of(leaves, foliage.card_table));
      variants.push_back(std::move(variant));
    }
  return variants;
}

}  // namespace coppice::bake
