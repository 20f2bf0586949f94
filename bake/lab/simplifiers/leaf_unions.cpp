#include "leaf_unions.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <string>
#include <tuple>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "check.h"
#include "collapse_geometric.h"
#include "gltf_write.h"
#include "greedy_union.h"
#include "quad_merge.h"

namespace coppice::bake {
namespace {

/// A leaf, of the source or one that replaces two.
struct UnitedLeaf {
  Quad quad{};
  std::uint32_t card = 0;
  std::uint16_t normals = kFlatNormals;  ///< a leaf that replaces two is flat
};

std::vector<UnitedLeaf> united_leaves(const Foliage& foliage) {
  std::vector<UnitedLeaf> leaves;
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf)
    leaves.push_back({foliage.quads[leaf], foliage.cards[leaf], foliage.normals.empty() ? kFlatNormals : foliage.normals[leaf]});
  return leaves;
}

/// The levels that unions give, one step after another.
template <class Unions>
Variant variant_of(std::string parameters, Unions unions, const std::vector<Card>& card_table,
                   const std::vector<std::uint32_t>& leaf_counts) {
  Variant variant{std::move(parameters), {}};
  for (const auto& leaves : unite_to(std::move(unions), leaf_counts)) {
    Foliage foliage;
    foliage.card_table = card_table;
    for (const UnitedLeaf& leaf : leaves) {
      foliage.quads.push_back(leaf.quad);
      foliage.cards.push_back(leaf.card);
      foliage.normals.push_back(leaf.normals);
    }
    variant.levels.push_back(Level{foliage_mesh(foliage)});
  }
  return variant;
}

using QuadCost = std::function<double(const Quad&, const Quad&)>;
using QuadUnion = std::function<Quad(const Quad&, const Quad&)>;

GreedyUnion<UnitedLeaf> greedy_union(const Foliage& foliage, QuadCost cost, QuadUnion unite) {
  UnionRules<UnitedLeaf> rules;
  rules.cost = [cost = std::move(cost)](const UnitedLeaf& a, const UnitedLeaf& b) { return cost(a.quad, b.quad); };
  rules.unite = [unite = std::move(unite)](const UnitedLeaf& a, const UnitedLeaf& b) {
    return UnitedLeaf{unite(a.quad, b.quad), merged_card(a.quad, a.card, b.quad, b.card)};
  };
  rules.middle = [](const UnitedLeaf& leaf) { return quad_centroid(leaf.quad); };
  return {foliage, united_leaves(foliage), std::move(rules)};
}

/// 1 - |n1 . n2|: 0 for parallel leaves, 1 for leaves at right angles, or without area.
double leaf_angle(const Quad& first, const Quad& second) {
  return 1.0 - std::min(1.0, std::abs(glm::dot(quad_normal(first), quad_normal(second))));
}

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

using Group = std::vector<std::uint32_t>;

glm::vec3 stalk_of(const Quad& quad) {
  return 0.5f * (quad[0] + quad[3]);
}

/// Halves a group at the median along the longest side of the stalks' box.
std::pair<Group, Group> halved(const Foliage& foliage, Group leaves) {
  glm::vec3 low = stalk_of(foliage.quads[leaves[0]]), high = low;
  for (const std::uint32_t leaf : leaves) {
    low = glm::min(low, stalk_of(foliage.quads[leaf]));
    high = glm::max(high, stalk_of(foliage.quads[leaf]));
  }
  const glm::vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::ranges::sort(leaves, {}, [&](std::uint32_t leaf) { return std::pair(stalk_of(foliage.quads[leaf])[axis], leaf); });
  const auto middle = leaves.begin() + static_cast<std::ptrdiff_t>((leaves.size() + 1) / 2);
  return {Group(leaves.begin(), middle), Group(middle, leaves.end())};
}

/// The unions of one level of the hierarchy: only pairs within a group.
class OrgansUnion {
 public:
  OrgansUnion(const Foliage& foliage, std::uint32_t max_size)
      : leaf_size_m_(mean_leaf_size_m(foliage)),
        leaves_(united_leaves(foliage)),
        live_(leaves_.size(), true),
        live_count_(foliage.leaf_count()),
        groups_(stalk_groups(foliage, max_size)) {
    open_floor();
  }

  [[nodiscard]] std::uint32_t live_count() const { return live_count_; }

  [[nodiscard]] std::vector<UnitedLeaf> live_items() const {
    std::vector<UnitedLeaf> leaves;
    for (std::size_t id = 0; id < leaves_.size(); ++id)
      if (live_[id]) leaves.push_back(leaves_[id]);
    return leaves;
  }

  /// Unites the cheapest pair. At least two leaves must be live.
  void step() {
    while (bests_.empty()) next_floor();
    const auto [cost, first, second, group] = bests_.top();
    bests_.pop();
    const UnitedLeaf &a = leaves_[first], &b = leaves_[second];
    const UnitedLeaf united{united_rectangle(a.quad, b.quad, RectangleLength::similar), merged_card(a.quad, a.card, b.quad, b.card)};
    live_[first] = live_[second] = false;
    const auto id = static_cast<std::uint32_t>(leaves_.size());
    leaves_.push_back(united);
    live_.push_back(true);
    --live_count_;
    std::erase_if(groups_[group], [&](std::uint32_t leaf) { return !live_[leaf]; });
    groups_[group].push_back(id);
    push_best(group);
  }

 private:
  /// (cost, smaller id, larger id, group)
  using Best = std::tuple<double, std::uint32_t, std::uint32_t, std::size_t>;

  void push_best(std::size_t group) {
    const Group& leaves = groups_[group];
    std::optional<Best> best;
    for (std::size_t i = 0; i < leaves.size(); ++i)
      for (std::size_t j = i + 1; j < leaves.size(); ++j) {
        constexpr double kAngleWeight = 1.0;
        const auto [first, second] = std::minmax(leaves[i], leaves[j]);
        const Best pair{leaves_union_cost(leaves_[first].quad, leaves_[second].quad, kAngleWeight, leaf_size_m_), first, second, group};
        if (!best || pair < *best) best = pair;
      }
    if (best) bests_.push(*best);
  }

  void open_floor() {
    for (std::size_t group = 0; group < groups_.size(); ++group) push_best(group);
  }

  /// Goes up one level: two neighbouring groups become one.
  void next_floor() {
    COPPICE_ASSERT(groups_.size() > 1);
    std::vector<Group> wholes;
    for (std::size_t i = 0; i < groups_.size(); i += 2) {
      wholes.push_back(groups_[i]);
      if (i + 1 < groups_.size()) wholes.back().insert(wholes.back().end(), groups_[i + 1].begin(), groups_[i + 1].end());
    }
    groups_ = std::move(wholes);
    open_floor();
  }

  double leaf_size_m_;
  std::vector<UnitedLeaf> leaves_;  ///< [id]
  std::vector<bool> live_;          ///< [id]
  std::uint32_t live_count_;
  std::vector<Group> groups_;
  std::priority_queue<Best, std::vector<Best>, std::greater<>> bests_;
};

}  // namespace

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
  const Quad& larger = first_area < second_area ? second : first;
  if (!(glm::length(axis) > 0.0)) return larger;
  axis = glm::normalize(axis);
  if (glm::dot(axis, axis_of(first)) < 0.0) axis = -axis;
  const glm::dvec3 middle = (first_area * quad_centroid(first) + second_area * quad_centroid(second)) / area;
  const double long_m = length == RectangleLength::extent ? extent_along(corners, axis) : similar_length(larger, area);
  const glm::dvec3 half = 0.5 * long_m * axis, across = 0.5 * area / long_m * glm::cross(normal, axis);
  return {glm::vec3(middle - half - across), glm::vec3(middle + half - across), glm::vec3(middle + half + across),
          glm::vec3(middle - half + across)};
}

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
  const auto farthest = [](const Quad& a, const Quad& b) { return merged_quad(a, b, merge_corners(a, b)); };
  std::vector<Variant> variants;
  for (const auto& [name, unite] : {std::pair<std::string, QuadUnion>{"farthest", farthest}, {"area", area_keeping_quad}})
    for (const double angle_weight : {0.1, 0.25, 0.5, 0.75, 0.9}) {
      const auto cost = [=, leaf_size_m = mean_leaf_size_m(foliage)](const Quad& a, const Quad& b) {
        return fsa_error(a, b, angle_weight, leaf_size_m);
      };
      variants.push_back(variant_of(name + ", angle " + std::to_string(angle_weight).substr(0, 4), greedy_union(foliage, cost, unite),
                                    foliage.card_table, leaf_counts));
    }
  return variants;
}

double leaves_union_cost(const Quad& first, const Quad& second, double angle_weight, double leaf_size_m) {
  const double first_area = quad_area(first), second_area = quad_area(second), sum = first_area + second_area;
  const double unequal = sum > 0.0 ? std::abs(first_area - second_area) / sum : 0.0;
  const double large = leaf_size_m > 0.0 ? glm::length(diameter_of(corners_of(first, second))) / leaf_size_m : 0.0;
  return large + angle_weight * leaf_angle(first, second) + unequal;
}

std::vector<Variant> unite_leaves(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts) {
  std::vector<Variant> variants;
  for (const RectangleLength length : {RectangleLength::extent, RectangleLength::similar})
    for (const double angle_weight : {0.5, 1.0, 2.0, 4.0}) {
      const std::string name = length == RectangleLength::extent ? "extent" : "similar";
      const auto cost = [=, leaf_size_m = mean_leaf_size_m(foliage)](const Quad& a, const Quad& b) {
        return leaves_union_cost(a, b, angle_weight, leaf_size_m);
      };
      const auto unite = [=](const Quad& a, const Quad& b) { return united_rectangle(a, b, length); };
      variants.push_back(variant_of(name + ", angle " + std::to_string(angle_weight).substr(0, 3), greedy_union(foliage, cost, unite),
                                    foliage.card_table, leaf_counts));
    }
  return variants;
}

std::vector<std::vector<std::uint32_t>> stalk_groups(const Foliage& foliage, std::uint32_t max_size) {
  COPPICE_ASSERT(max_size >= 1 && foliage.leaf_count() >= 1);
  std::vector<Group> groups(1, Group(foliage.leaf_count()));
  std::iota(groups[0].begin(), groups[0].end(), 0u);
  while (groups[0].size() > max_size) {  // the first is the largest: an odd leaf stays in the first half
    std::vector<Group> halves;
    for (Group& group : groups) {
      auto [first, second] = halved(foliage, std::move(group));
      halves.push_back(std::move(first));
      halves.push_back(std::move(second));
    }
    groups = std::move(halves);
  }
  return groups;
}

std::vector<Variant> unite_organs(const Foliage& foliage, const std::vector<std::uint32_t>& leaf_counts) {
  std::vector<Variant> variants;
  for (const std::uint32_t max_size : {4u, 8u, 16u, 32u, 64u})
    variants.push_back(
        variant_of("groups of " + std::to_string(max_size), OrgansUnion(foliage, max_size), foliage.card_table, leaf_counts));
  return variants;
}

}  // namespace coppice::bake
