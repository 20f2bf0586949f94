// Computes each point's distance from the ground along edges (Dijkstra), and cuts the surface into bands of that distance. A connected part
// of a band is a ring. A ring's parent is the ring through which the shortest way from the ground enters it.

#include "wood_skeleton.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include <glm/geometric.hpp>

#include "union_find.h"
#include "wood_graph.h"

namespace coppice::bake {
namespace {

/// Points this near to the ground touch it, relative to the plant's height.
constexpr double kGroundShare = 0.02;
/// A piece that touches the ground is a hanging twig if it has less than this share of the largest one's surface.
constexpr double kSlightShare = 0.05;
/// Maximum depth of roots below y = 0, where most plants stand, relative to the plant's height.
constexpr double kRootShare = 0.2;

/// Maximum number of points. Rings are farther apart if wood has so much surface that it would need more.
constexpr double kMaxSplitPoints = 1 << 18;

constexpr double kFar = std::numeric_limits<double>::infinity();

/// Height above the end by which the plant is held.
double rise_m(const Stand& stand, const glm::vec3& point) {
  return stand.hangs ? stand.top_y_m - point.y : point.y - stand.base_y_m;
}

/// Points from which distances count: those near the ground, of each piece that stands on it.
std::vector<std::uint32_t> ground_points(const WoodGraph& graph, const Stand& stand) {
  std::vector<double> lows_m(graph.points.size(), kFar);
  for (std::uint32_t i = 0; i < graph.points.size(); ++i) {
    double& low_m = lows_m[graph.pieces[i]];
    low_m = std::min(low_m, rise_m(stand, graph.points[i]));
  }
  const double near_m = kGroundShare * stand.height_m();
  const double ground_m = std::max(*std::ranges::min_element(lows_m), 0.0) + near_m;
  double largest_m2 = 0.0;
  for (std::uint32_t i = 0; i < graph.points.size(); ++i)
    if (lows_m[i] <= ground_m) largest_m2 = std::max(largest_m2, graph.piece_areas_m2[i]);
  std::vector<std::uint32_t> points;
  for (std::uint32_t i = 0; i < graph.points.size(); ++i) {
    const std::uint32_t piece = graph.pieces[i];
    const bool stands = lows_m[piece] <= ground_m && graph.piece_areas_m2[piece] >= kSlightShare * largest_m2;
    if (stands && rise_m(stand, graph.points[i]) <= std::max(lows_m[piece], 0.0) + near_m) points.push_back(i);
  }
  return points;
}

/// Distances from the ground, and the point through which the way there goes.
struct Ways {
  std::vector<double> distances_m;
  std::vector<std::uint32_t> from;   ///< kNone for points on the ground
  std::vector<std::uint32_t> order;  ///< points in the order in which they were reached
};

Ways ways_from_ground(const WoodGraph& graph, const Stand& stand) {
  Ways ways{std::vector<double>(graph.points.size(), kFar), std::vector<std::uint32_t>(graph.points.size(), kNone), {}};
  std::vector<bool> is_reached(graph.points.size(), false);
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
  for (const std::uint32_t point : ground_points(graph, stand)) {
    ways.distances_m[point] = 0.0;
    next.emplace(0.0, point);
  }
  while (!next.empty()) {
    const auto [distance_m, point] = next.top();
    next.pop();
    if (is_reached[point]) continue;
    is_reached[point] = true;
    ways.order.push_back(point);
    for (const std::uint32_t to : graph.links_of(point)) {
      const double reached_m = distance_m + glm::distance(glm::dvec3(graph.points[point]), glm::dvec3(graph.points[to]));
      if (!(reached_m < ways.distances_m[to])) continue;
      ways.distances_m[to] = reached_m;
      ways.from[to] = point;
      next.emplace(reached_m, to);
    }
  }
  return ways;
}

/// The ring of each point. Rings are numbered as they were reached, so a ring's parent comes before it.
struct Bands {
  std::vector<std::uint32_t> ring_of;  ///< [points]
  std::vector<std::uint32_t> parents;  ///< [rings]
};

Bands take_bands(const WoodGraph& graph, const Ways& ways, double ring_m) {
  const auto band = [&](std::uint32_t point) { return std::floor(ways.distances_m[point] / ring_m); };
  UnionFind sets(graph.points.size());
  for (std::uint32_t point = 0; point < graph.points.size(); ++point)
    for (const std::uint32_t to : graph.links_of(point))
      if (to > point && graph.pieces[to] == graph.pieces[point] && band(to) == band(point)) sets.join(point, to);
  Bands bands{std::vector<std::uint32_t>(graph.points.size(), kNone), {}};
  std::vector<std::uint32_t> ring_of_set(graph.points.size(), kNone);
  for (const std::uint32_t point : ways.order) {
    std::uint32_t& ring = ring_of_set[sets.find(point)];
    if (ring == kNone) {
      ring = static_cast<std::uint32_t>(bands.parents.size());
      bands.parents.push_back(ways.from[point] == kNone ? kNone : bands.ring_of[ways.from[point]]);
    }
    bands.ring_of[point] = ring;
  }
  return bands;
}

/// Merges bumps into their parent: a ring without children, beside one with children, is no branch.
Bands without_bumps(const Bands& bands) {
  const std::size_t count = bands.parents.size();
  std::vector<std::uint32_t> child_counts(count, 0u), longer_children(count, 0u);
  for (const std::uint32_t parent : bands.parents)
    if (parent != kNone) ++child_counts[parent];
  for (std::size_t i = 0; i < count; ++i)
    if (bands.parents[i] != kNone && child_counts[i] > 0) ++longer_children[bands.parents[i]];
  Bands kept{bands.ring_of, {}};
  std::vector<std::uint32_t> number(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t parent = bands.parents[i];
    if (parent != kNone && child_counts[i] == 0 && longer_children[parent] > 0) {
      number[i] = number[parent];
      continue;
    }
    number[i] = static_cast<std::uint32_t>(kept.parents.size());
    kept.parents.push_back(parent == kNone ? kNone : number[parent]);
  }
  for (std::uint32_t& ring : kept.ring_of) ring = number[ring];
  return kept;
}

/// Triangles that are split at their longest edges have about three corners for each square of that edge.
double possible_ring_m(const Mesh& wood, double ring_m) {
  double surface_m2 = 0.0;
  for (std::size_t i = 0; i < wood.indices.size(); i += 3) surface_m2 += triangle_m2(at_corners(wood.positions, wood.indices, i));
  return std::max(ring_m, std::sqrt(3.0 * surface_m2 / kMaxSplitPoints));
}

Bands bands_of(const WoodGraph& graph, const Stand& stand, double ring_m) {
  return without_bumps(take_bands(graph, ways_from_ground(graph, stand), ring_m));
}

/// [ring] Its direction: away from its parent, or up for a ring on the ground.
std::vector<glm::dvec3> ring_axes(const std::vector<Ring>& rings) {
  constexpr glm::dvec3 kUp(0.0, 1.0, 0.0);
  std::vector<glm::dvec3> axes(rings.size(), kUp);
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (rings[i].parent == kNone) continue;
    const glm::dvec3 away = rings[i].center - rings[rings[i].parent].center;
    const double length_m = glm::length(away);
    if (length_m > 0.0) axes[i] = away / length_m;
  }
  return axes;
}

void set_centers_and_radii(const WoodGraph& graph, const Bands& bands, double min_m, std::vector<Ring>& rings) {
  std::vector<double> sums_m(rings.size(), 0.0), counts(rings.size(), 0.0);
  for (std::uint32_t i = 0; i < graph.points.size(); ++i) {
    rings[bands.ring_of[i]].center += glm::dvec3(graph.points[i]);
    counts[bands.ring_of[i]] += 1.0;
  }
  for (std::size_t i = 0; i < rings.size(); ++i) rings[i].center /= counts[i];
  const std::vector<glm::dvec3> axes = ring_axes(rings);
  for (std::uint32_t i = 0; i < graph.points.size(); ++i) {
    const std::uint32_t ring = bands.ring_of[i];
    sums_m[ring] += glm::length(glm::cross(glm::dvec3(graph.points[i]) - rings[ring].center, axes[ring]));
  }
  for (std::size_t i = 0; i < rings.size(); ++i) rings[i].radius_m = std::max(sums_m[i] / counts[i], min_m);
}

/// Replaces each radius by the median of the ring's and those of up to two rings below and two above: rings at forks come out too thick,
/// those of stems in several pieces too thin.
void smooth_radii(std::vector<Ring>& rings) {
  std::vector<std::uint32_t> thickest_child(rings.size(), kNone);
  for (std::uint32_t i = 0; i < rings.size(); ++i) {
    if (rings[i].parent == kNone) continue;
    std::uint32_t& child = thickest_child[rings[i].parent];
    if (child == kNone || rings[i].radius_m > rings[child].radius_m) child = i;
  }
  std::vector<double> middles_m;
  for (std::uint32_t i = 0; i < rings.size(); ++i) {
    std::vector<double> radii_m{rings[i].radius_m};
    for (std::uint32_t step = 0, at = rings[i].parent; step < 2 && at != kNone; ++step, at = rings[at].parent)
      radii_m.push_back(rings[at].radius_m);
    for (std::uint32_t step = 0, at = thickest_child[i]; step < 2 && at != kNone; ++step, at = thickest_child[at])
      radii_m.push_back(rings[at].radius_m);
    middles_m.push_back(quantile(std::move(radii_m), 5));
  }
  for (std::size_t i = 0; i < rings.size(); ++i) rings[i].radius_m = middles_m[i];
}

}  // namespace

Stand stand_of(double low_y_m, double high_y_m) {
  Stand stand{low_y_m, high_y_m, false};
  const double height_m = stand.height_m();
  stand.hangs = stand.base_y_m < 0.0 && stand.top_y_m <= 0.01 * height_m;
  if (!stand.hangs && stand.base_y_m < 0.0 && stand.base_y_m + kRootShare * height_m > 0.0) stand.base_y_m = 0.0;
  return stand;
}

double quantile(std::vector<double> values, std::size_t tenths) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * tenths / 10);
  std::ranges::nth_element(values, at);
  return *at;
}

std::vector<Ring> wood_skeleton(const Mesh& wood, const Stand& stand, double ring_m) {
  if (wood.indices.empty() || !(ring_m > 0.0)) return {};
  ring_m = possible_ring_m(wood, ring_m);
  const WoodGraph graph = wood_graph(wood, ring_m);
  const Bands bands = bands_of(graph, stand, ring_m);
  std::vector<Ring> rings(bands.parents.size());
  for (std::size_t i = 0; i < rings.size(); ++i) rings[i].parent = bands.parents[i];
  set_centers_and_radii(graph, bands, 1e-3 * ring_m, rings);
  smooth_radii(rings);
  for (Ring& ring : rings)
    if (ring.parent != kNone) ring.length_m = glm::distance(ring.center, rings[ring.parent].center);
  return rings;
}

std::vector<std::uint32_t> wood_limbs(const Mesh& wood, const Stand& stand, double ring_m) {
  if (wood.indices.empty() || !(ring_m > 0.0)) return std::vector<std::uint32_t>(wood.indices.size() / 3, 0u);
  ring_m = possible_ring_m(wood, ring_m);
  const WoodGraph graph = wood_graph(wood, ring_m);
  const Bands bands = bands_of(graph, stand, ring_m);
  const std::vector<std::uint32_t> limb_of_ring = limbs_of_rings(bands.parents);
  std::vector<std::uint32_t> limbs;
  for (std::size_t i = 0; i < graph.corners.size(); i += 3) {
    // A long triangle belongs to its last ring: below a fork is the stem, whose last ring is that of the fork.
    std::uint32_t last = 0;
    for (std::size_t k = 0; k < 3; ++k) last = std::max(last, bands.ring_of[graph.corners[i + k]]);
    limbs.push_back(limb_of_ring[last]);
  }
  return limbs;
}

std::vector<std::uint32_t> limbs_of_rings(const std::vector<std::uint32_t>& parents) {
  const std::size_t count = parents.size();
  std::vector<std::uint32_t> tips(count, 0u);  // rings from the ground to the farthest tip beyond
  for (std::size_t i = 0; i < count; ++i) tips[i] = parents[i] == kNone ? 1u : tips[parents[i]] + 1u;
  for (std::size_t i = count; i-- > 0;)
    if (parents[i] != kNone) tips[parents[i]] = std::max(tips[parents[i]], tips[i]);
  std::vector<std::uint32_t> limbs(count);
  std::vector<bool> goes_on(count, false);
  std::uint32_t limb_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t parent = parents[i];
    const bool is_next = parent != kNone && !goes_on[parent] && tips[i] == tips[parent];
    if (is_next) goes_on[parent] = true;
    limbs[i] = is_next ? limbs[parent] : limb_count++;
  }
  return limbs;
}

}  // namespace coppice::bake
