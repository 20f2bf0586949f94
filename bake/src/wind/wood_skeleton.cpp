// How far each point of the surface is from the ground, along edges (Dijkstra); the surface in bands of that distance; what is connected of
// a band is a ring. A ring's parent is the one through which the shortest way from the ground enters it.

#include "wood_skeleton.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include <glm/geometric.hpp>

#include "union_find.h"
#include "wood_graph.h"

namespace coppice::bake {
namespace {

/// Of the height: what is this near to the ground touches it.
constexpr double kGroundShare = 0.02;
/// A piece that touches the ground and has less than this share of the largest one's surface is a twig that hangs down to it.
constexpr double kSlightShare = 0.02;

constexpr double kFar = std::numeric_limits<double>::infinity();

/// How high above the end by which the plant is held.
double rise_m(const Stand& stand, const glm::vec3& point) {
  return stand.hangs ? stand.top_y_m - point.y : point.y - stand.base_y_m;
}

/// Points from which distances count: of each piece that stands on the ground those near to it.
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

/// Distances from the ground, and through which point the way there goes.
struct Ways {
  std::vector<double> distances_m;
  std::vector<std::uint32_t> from;  ///< kNone on the ground
};

Ways ways_from_ground(const WoodGraph& graph, const Stand& stand) {
  Ways ways{std::vector<double>(graph.points.size(), kFar), std::vector<std::uint32_t>(graph.points.size(), kNone)};
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
  for (const std::uint32_t point : ground_points(graph, stand)) {
    ways.distances_m[point] = 0.0;
    next.emplace(0.0, point);
  }
  while (!next.empty()) {
    const auto [distance_m, point] = next.top();
    next.pop();
    if (distance_m > ways.distances_m[point]) continue;
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

/// By point the ring it is in, rings numbered from the ground on.
struct Bands {
  std::vector<std::uint32_t> ring_of;  ///< [points]
  std::vector<std::uint32_t> first;    ///< [rings] its point nearest to the ground
};

Bands take_bands(const WoodGraph& graph, const Ways& ways, double ring_m) {
  const auto band = [&](std::uint32_t point) { return std::floor(ways.distances_m[point] / ring_m); };
  UnionFind sets(graph.points.size());
  for (std::uint32_t point = 0; point < graph.points.size(); ++point)
    for (const std::uint32_t to : graph.links_of(point))
      if (to > point && band(to) == band(point)) sets.join(point, to);
  std::vector<std::uint32_t> order(graph.points.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](std::uint32_t point) { return std::pair(ways.distances_m[point], point); });
  Bands bands{std::vector<std::uint32_t>(graph.points.size(), kNone), {}};
  for (const std::uint32_t point : order) {
    std::uint32_t& ring = bands.ring_of[sets.find(point)];
    if (ring == kNone) {
      ring = static_cast<std::uint32_t>(bands.first.size());
      bands.first.push_back(point);
    }
    bands.ring_of[point] = ring;
  }
  return bands;
}

void set_centers(const WoodGraph& graph, const Bands& bands, std::vector<Ring>& rings) {
  std::vector<double> counts(rings.size(), 0.0);
  for (std::uint32_t i = 0; i < graph.points.size(); ++i) {
    rings[bands.ring_of[i]].center += glm::dvec3(graph.points[i]);
    counts[bands.ring_of[i]] += 1.0;
  }
  for (std::size_t i = 0; i < rings.size(); ++i) rings[i].center /= counts[i];
}

/// Along each ring: away from its parent, or from the ground towards its child.
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

void set_radii(const WoodGraph& graph, const Bands& bands, double least_m, std::vector<Ring>& rings) {
  const std::vector<glm::dvec3> axes = ring_axes(rings);
  std::vector<double> sums_m(rings.size(), 0.0), counts(rings.size(), 0.0);
  for (std::uint32_t i = 0; i < graph.points.size(); ++i) {
    const std::uint32_t ring = bands.ring_of[i];
    sums_m[ring] += glm::length(glm::cross(glm::dvec3(graph.points[i]) - rings[ring].center, axes[ring]));
    counts[ring] += 1.0;
  }
  for (std::size_t i = 0; i < rings.size(); ++i) rings[i].radius_m = std::max(sums_m[i] / counts[i], least_m);
}

}  // namespace

std::vector<Ring> wood_skeleton(const Mesh& wood, const Stand& stand, double ring_m) {
  if (wood.indices.empty() || !(ring_m > 0.0)) return {};
  const WoodGraph graph = wood_graph(wood, 0.75 * ring_m);
  const Ways ways = ways_from_ground(graph, stand);
  const Bands bands = take_bands(graph, ways, ring_m);
  std::vector<Ring> rings(bands.first.size());
  for (std::size_t i = 0; i < rings.size(); ++i) {
    std::uint32_t before = ways.from[bands.first[i]];
    while (before != kNone && bands.ring_of[before] == i) before = ways.from[before];  // through a point in the same place
    if (before != kNone) rings[i].parent = bands.ring_of[before];
  }
  set_centers(graph, bands, rings);
  set_radii(graph, bands, 1e-3 * ring_m, rings);
  for (Ring& ring : rings)
    if (ring.parent != kNone) ring.length_m = glm::distance(ring.center, rings[ring.parent].center);
  return rings;
}

}  // namespace coppice::bake
