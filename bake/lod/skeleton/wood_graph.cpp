// Links between loose pieces are nearly a minimum spanning tree: pieces are joined in rounds. In each round points lie in cells, twice as
// wide as in the round before, and pieces that have points in one cell or in two touching cells are joined, the nearest first. A cell keeps
// one point of each piece, so that rounds get shorter.

#include "wood_graph.h"

#include <algorithm>
#include <compare>
#include <numeric>
#include <unordered_map>
#include <utility>

#include <glm/geometric.hpp>

#include "bounds.h"
#include "union_find.h"
#include "weld.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kMaxPoints = std::size_t{1} << 20;

using Link = std::pair<std::uint32_t, std::uint32_t>;  // the lower point first

Link link_of(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Sets the graph's corners, and its points to the welded vertices.
void weld_wood(const Mesh& wood, WoodGraph& graph) {
  const std::vector<std::uint32_t> welded = weld(wood.positions, std::vector<std::uint32_t>(wood.positions.size(), 0u));
  std::vector<std::uint32_t> number(welded.size(), kNone);
  for (const std::uint32_t index : wood.indices) {
    std::uint32_t& point = number[welded[index]];
    if (point == kNone) {
      point = static_cast<std::uint32_t>(graph.points.size());
      graph.points.push_back(wood.positions[welded[index]]);
    }
    graph.corners.push_back(point);
  }
}

/// Splits triangles at the middle of their longest edge until no edge is longer than spacing_m. Triangles that share an edge share its
/// middle, which is added to `points`. Returns the edges of all parts.
std::vector<Link> split_long_edges(const std::vector<std::uint32_t>& corners, double spacing_m, std::vector<glm::vec3>& points) {
  using Triangle = std::array<std::uint32_t, 3>;
  const auto length_m = [&](const Triangle& triangle, std::size_t k) {
    return glm::distance(glm::dvec3(points[triangle[k]]), glm::dvec3(points[triangle[(k + 1) % 3]]));
  };
  std::unordered_map<std::uint64_t, std::uint32_t> middles;  // by edge
  std::vector<Link> links;
  std::vector<Triangle> left;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    left.push_back({corners[i], corners[i + 1], corners[i + 2]});
    while (!left.empty()) {
      const Triangle each = left.back();
      left.pop_back();
      std::size_t longest = 0;
      for (std::size_t k = 1; k < 3; ++k)
        if (length_m(each, k) > length_m(each, longest)) longest = k;
      if (!(length_m(each, longest) > spacing_m) || points.size() >= kMaxPoints) {
        for (std::size_t k = 0; k < 3; ++k)
          if (each[k] != each[(k + 1) % 3]) links.push_back(link_of(each[k], each[(k + 1) % 3]));
        continue;
      }
      const std::uint32_t a = each[longest], b = each[(longest + 1) % 3], c = each[(longest + 2) % 3];
      const auto [low, high] = link_of(a, b);
      const auto [middle, is_new] = middles.try_emplace(std::uint64_t{low} << 32 | high, static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back(0.5f * (points[low] + points[high]));
      left.push_back({a, middle->second, c});
      left.push_back({middle->second, b, c});
    }
  }
  return links;
}

/// A point of a piece in a cell of a round.
struct Filed {
  std::uint64_t cell = 0;
  std::uint32_t piece = 0, point = 0;
  auto operator<=>(const Filed&) const = default;
};

constexpr std::uint32_t kCellBits = 21;

std::uint64_t cell_of(const glm::dvec3& at) {
  std::uint64_t cell = 0;
  for (int axis = 0; axis < 3; ++axis) cell = cell << kCellBits | (static_cast<std::uint64_t>(std::max(at[axis], 0.0)) + 1);
  return cell;
}

std::span<const Filed> in_cell(const std::vector<Filed>& filed, std::uint64_t cell) {
  return {std::ranges::lower_bound(filed, cell, {}, &Filed::cell), std::ranges::upper_bound(filed, cell, {}, &Filed::cell)};
}

struct Candidate {
  float distance_m = 0.0f;
  std::uint32_t a = 0, b = 0;  ///< points
  auto operator<=>(const Candidate&) const = default;
};

/// Pairs a cell's points with each other and with those of the cells after it.
std::vector<Candidate> round_pairs(const std::vector<glm::vec3>& points, const std::vector<Filed>& filed) {
  std::vector<Candidate> candidates;
  const auto add = [&](const Filed& a, const Filed& b) {
    if (a.piece != b.piece)
      candidates.push_back({glm::distance(points[a.point], points[b.point]), std::min(a.point, b.point), std::max(a.point, b.point)});
  };
  const auto add_pairs = [&](std::span<const Filed> own, std::span<const Filed> others) {
    constexpr std::size_t kMaxPerCell = 48;
    for (const Filed& a : own.first(std::min(own.size(), kMaxPerCell)))
      for (const Filed& b : others.first(std::min(others.size(), kMaxPerCell)))
        if (own.data() != others.data() || &a < &b) add(a, b);
  };
  for (std::size_t first = 0, last = 0; first < filed.size(); first = last) {
    while (last < filed.size() && filed[last].cell == filed[first].cell) ++last;
    const std::span<const Filed> own = std::span(filed).subspan(first, last - first);
    add_pairs(own, own);
    // Joins all points of a crowded cell.
    for (std::size_t i = 1; i < own.size(); ++i) add(own[i - 1], own[i]);
    for (int step = 14; step < 27; ++step) {
      const std::uint64_t x = static_cast<std::uint64_t>(step / 9) - 1, y = static_cast<std::uint64_t>(step / 3 % 3) - 1,
                          z = static_cast<std::uint64_t>(step % 3) - 1;
      // Below 0 wraps, which carries into the next part with the right result: cells start at 1 on every axis.
      add_pairs(own, in_cell(filed, own[0].cell + (x << 2 * kCellBits) + (y << kCellBits) + z));
    }
  }
  std::ranges::sort(candidates);
  return candidates;
}

/// Adds links that connect all pieces.
void join_pieces(const std::vector<glm::vec3>& points, const std::vector<std::uint32_t>& pieces, std::vector<Link>& links) {
  UnionFind sets(points.size());
  std::size_t set_count = 0;
  std::vector<Filed> filed;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (pieces[i] == i) ++set_count;
    filed.push_back({0, 0, i});
  }
  const auto box = box_of(points);
  const glm::dvec3 low(box.low), extent = glm::dvec3(box.high) - low;
  double cell_m = std::max({extent.x, extent.y, extent.z}) / 4096.0;
  while (set_count > 1 && cell_m > 0.0) {
    for (Filed& each : filed) {
      each.cell = cell_of((glm::dvec3(points[each.point]) - low) / cell_m);
      each.piece = sets.find(pieces[each.point]);
    }
    std::ranges::sort(filed);
    const auto same = [](const Filed& a, const Filed& b) { return a.cell == b.cell && a.piece == b.piece; };
    filed.erase(std::unique(filed.begin(), filed.end(), same), filed.end());
    for (const Candidate& pair : round_pairs(points, filed)) {
      if (sets.find(pieces[pair.a]) == sets.find(pieces[pair.b])) continue;
      sets.join(pieces[pair.a], pieces[pair.b]);
      links.push_back({pair.a, pair.b});
      --set_count;
    }
    cell_m *= 2.0;
  }
}

void set_links(std::vector<Link> links, WoodGraph& graph) {
  const std::size_t count = links.size();
  for (std::size_t i = 0; i < count; ++i) links.emplace_back(links[i].second, links[i].first);
  std::ranges::sort(links);
  links.erase(std::unique(links.begin(), links.end()), links.end());
  graph.first_links.assign(graph.points.size() + 1, 0u);
  for (const auto& [from, to] : links) {
    ++graph.first_links[from + 1];
    graph.links.push_back(to);
  }
  std::partial_sum(graph.first_links.begin(), graph.first_links.end(), graph.first_links.begin());
}

}  // namespace

double triangle_m2(const std::array<glm::vec3, 3>& corners) {
  const glm::dvec3 from(corners[0]);
  return 0.5 * glm::length(glm::cross(glm::dvec3(corners[1]) - from, glm::dvec3(corners[2]) - from));
}

WoodGraph wood_graph(const Mesh& wood, double spacing_m) {
  WoodGraph graph;
  weld_wood(wood, graph);
  if (graph.points.empty()) {
    graph.first_links = {0};
    return graph;
  }
  std::vector<Link> links = split_long_edges(graph.corners, spacing_m, graph.points);
  UnionFind sets(graph.points.size());
  for (const auto& [a, b] : links) sets.join(a, b);
  for (std::uint32_t i = 0; i < graph.points.size(); ++i) graph.pieces.push_back(sets.find(i));
  graph.piece_areas_m2.assign(graph.points.size(), 0.0);
  for (std::size_t i = 0; i < graph.corners.size(); i += 3)
    graph.piece_areas_m2[graph.pieces[graph.corners[i]]] += triangle_m2(at_corners(graph.points, graph.corners, i));
  join_pieces(graph.points, graph.pieces, links);
  set_links(std::move(links), graph);
  return graph;
}

}  // namespace coppice::bake
