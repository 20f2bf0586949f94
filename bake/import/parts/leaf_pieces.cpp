// Four partitions of the triangles, each found with union-find: by edge, by index, by both, by weld (see the header). All refine the last,
// so the choice is made within each welded piece on its own, with the counts of classes over the whole soup. Most welded pieces are the
// same set in every partition; only the others cost time. leaf_lobes.h afterwards joins what came apart and is one leaf all the same.

#include "leaf_pieces.h"

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <iterator>
#include <map>
#include <numeric>
#include <span>
#include <unordered_map>
#include <utility>

#include "leaf_lobes.h"
#include "piece_kinds.h"
#include "piece_points.h"
#include "union_find.h"

namespace coppice::bake {
namespace {

// A set falls into its parts if this share of it is parts of one class; the rest may be the rachis that bears them.
constexpr double kAlikeShare = 0.6;
// The same for leaves that share whole edges: stricter, because a shared edge speaks for one surface.
constexpr double kSameShare = 0.99;

/// Pieces with equal keys may be copies of each other.
struct ClassKey {
  std::uint32_t material = 0, triangle_count = 0, point_count = 0;
  auto operator<=>(const ClassKey&) const = default;
};

/// How many sets of a class each partition has. `alone` counts those that are the same in all.
struct ClassCounts {
  std::uint32_t alone = 0, welded = 0, both = 0, by_edge = 0, by_index = 0;
};

/// group_by for few items: no array as long as the soup.
template <class SetOf>
std::vector<std::vector<std::uint32_t>> part_by(TriangleList items, const SetOf& set_of) {
  std::vector<std::vector<std::uint32_t>> parts;
  std::unordered_map<std::uint32_t, std::size_t> part_of;
  for (const std::uint32_t item : items) {
    const auto [found, is_new] = part_of.try_emplace(set_of(item), parts.size());
    if (is_new) parts.emplace_back();
    parts[found->second].push_back(item);
  }
  return parts;
}

/// An edge: its two points, the smaller first, and its owner. After sorting, edges of one place are neighbours.
using Edge = std::array<std::uint32_t, 3>;

Edge edge_between(std::uint32_t a, std::uint32_t b, std::uint32_t owner) {
  return {std::min(a, b), std::max(a, b), owner};
}

bool same_place(const Edge& a, const Edge& b) {
  return a[0] == b[0] && a[1] == b[1];
}

/// A triangle: its three points in rising order, and its number.
using SortedTriangle = std::pair<std::array<std::uint32_t, 3>, std::uint32_t>;

/// Joins triangles that are the same; returns the first of each.
std::vector<std::uint32_t> join_repeated(const Points& points, TriangleList triangles, UnionFind& sets) {
  std::vector<SortedTriangle> sorted;
  sorted.reserve(triangles.size());
  for (const std::uint32_t t : triangles) {
    sorted.emplace_back(points.of(t), t);
    std::ranges::sort(sorted.back().first);
  }
  std::ranges::sort(sorted);
  std::vector<std::uint32_t> distinct;
  distinct.reserve(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i > 0 && sorted[i].first == sorted[i - 1].first)
      sets.join(sorted[i].second, sorted[i - 1].second);
    else
      distinct.push_back(sorted[i].second);
  }
  return distinct;
}

/// Joins triangles across edges that have two of them. At an edge with three or more the surface branches: crossed cards, fins. Triangles
/// without area do not count, since they belong to the surface that they lie on.
void join_edges(const Points& points, TriangleList triangles, UnionFind& sets) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (const std::uint32_t t : triangles) {
    const auto corners = points.of(t);
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(edge_between(corners[k], corners[(k + 1) % 3], t));
  }
  std::ranges::sort(edges);
  for (auto first = edges.begin(), last = first; first != edges.end(); first = last) {
    last = std::find_if(first, edges.end(), [&](const Edge& edge) { return !same_place(edge, *first); });
    const auto thin = std::stable_partition(first, last, [&](const Edge& edge) { return points.has_area(edge[2]); });
    if (thin - first > 2) continue;
    if (thin - first == 2) sets.join(first[0][2], first[1][2]);
    for (auto edge = thin; edge != last; ++edge) sets.join((*first)[2], (*edge)[2]);
  }
}

/// Joins triangles that have corners with the same key.
template <class KeyOf>
void join_corners(TriangleList triangles, std::size_t key_count, const KeyOf& key_of, UnionFind& sets) {
  std::vector<std::uint32_t> first(key_count, kNone);
  for (const std::uint32_t t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& seen = first[key_of(t, k)];
      if (seen == kNone)
        seen = t;
      else
        sets.join(seen, t);
    }
}

class Splitter {
 public:
  Splitter(const Mesh& mesh, const Points& points, TriangleList triangles)
      : mesh_(mesh),
        points_(points),
        triangles_(triangles),
        by_edge_(mesh.triangle_materials.size()),
        by_index_(by_edge_),
        both_(0),
        welded_(0) {
    const std::vector<std::uint32_t> distinct = join_repeated(points_, triangles_, by_edge_);
    join_edges(points_, distinct, by_edge_);
    const auto vertex = [&](std::size_t t, std::size_t k) { return mesh_.indices[3 * t + k]; };
    join_corners(triangles_, mesh_.positions.size(), vertex, by_index_);
    both_ = by_edge_;
    join_corners(triangles_, mesh_.positions.size(), vertex, both_);
    welded_ = both_;
    join_corners(
        triangles_, points_.count(), [&](std::size_t t, std::size_t k) { return points_.of(t)[k]; }, welded_);
  }

  /// [triangle count of the mesh] Numbers the pieces: the number of each triangle's piece; kNone for triangles that were not given.
  std::vector<std::uint32_t> choose() {
    const Groups whole = group_by(triangles_, mesh_.triangle_materials.size(), [&](std::uint32_t t) { return welded_.find(t); });
    std::vector<std::size_t> mixed;
    for (std::size_t i = 0; i < whole.ranges.size(); ++i)
      if (!count_classes(whole.of(i))) mixed.push_back(i);
    piece_of_.assign(mesh_.triangle_materials.size(), kNone);
    for (const std::uint32_t t : triangles_) piece_of_[t] = welded_.find(t);
    for (const std::size_t i : mixed) choose_within(whole.of(i));
    return std::move(piece_of_);
  }

 private:
  /// The class of a set, by its triangles with area; by all if none has any.
  ClassKey class_of(TriangleList set) const {
    std::vector<std::uint32_t> used;
    used.reserve(3 * set.size());
    const bool has_area = std::ranges::any_of(set, [&](std::uint32_t t) { return points_.has_area(t); });
    for (const std::uint32_t t : set)
      if (points_.has_area(t) || !has_area)
        for (const std::uint32_t point : points_.of(t)) used.push_back(point);
    const auto triangle_count = static_cast<std::uint32_t>(used.size() / 3);
    std::ranges::sort(used);
    const auto distinct = std::unique(used.begin(), used.end()) - used.begin();
    return {mesh_.triangle_materials[set[0]], triangle_count, static_cast<std::uint32_t>(distinct)};
  }

  bool is_one(TriangleList set, UnionFind& sets) const {
    const std::uint32_t first = sets.find(set[0]);
    return std::ranges::all_of(set, [&](std::uint32_t t) { return sets.find(t) == first; });
  }

  auto parts(TriangleList set, UnionFind& sets) const {
    return part_by(set, [&](std::uint32_t t) { return sets.find(t); });
  }

  /// Counts a welded piece and its parts. Returns whether it is the same in all partitions.
  bool count_classes(TriangleList set) {
    ClassCounts& counts = counts_[class_of(set)];
    ++counts.welded;
    if (is_one(set, by_edge_) && is_one(set, by_index_)) {
      ++counts.alone, ++counts.both, ++counts.by_edge, ++counts.by_index;
      return true;
    }
    for (const auto& part : parts(set, both_)) ++counts_[class_of(part)].both;
    for (const auto& part : parts(set, by_edge_)) ++counts_[class_of(part)].by_edge;
    for (const auto& part : parts(set, by_index_)) ++counts_[class_of(part)].by_index;
    return false;
  }

  /// The class that most triangles of a set's parts have, the number of these parts, and their share of the set.
  struct MainClass {
    ClassKey key;
    std::size_t part_count = 0;
    double share = 0.0;
  };
  MainClass main_class(TriangleList set, const std::vector<std::vector<std::uint32_t>>& parts) const {
    std::map<ClassKey, std::size_t> triangle_counts;
    for (const auto& part : parts) triangle_counts[class_of(part)] += part.size();
    const auto dominant = std::ranges::max_element(triangle_counts, {}, [](const auto& entry) { return entry.second; });
    return {dominant->first, dominant->second / dominant->first.triangle_count,
            static_cast<double>(dominant->second) / static_cast<double>(set.size())};
  }

  void choose_within(TriangleList whole) {
    const auto pieces = parts(whole, both_);
    if (pieces.size() > 1 && is_one_shape(whole, pieces)) return;
    for (const auto& piece : pieces) {
      const auto edge_parts = parts(piece, by_edge_);
      if (edge_parts.size() > 1 && !are_alike(piece, edge_parts))
        assign(piece);
      else
        for (const auto& part : edge_parts) choose_by_index(part);
    }
  }

  /// Whether parts that touch in points are one thing: it is repeated as a whole, its parts are not alike, and it does not consist of
  /// things that are repeated within it, as a twig with leaves does.
  bool is_one_shape(TriangleList whole, const std::vector<std::vector<std::uint32_t>>& parts) {
    if (counts_[class_of(whole)].welded < kRepeated || has_many_of_each(whole, parts)) return false;
    const MainClass dominant = main_class(whole, parts);
    const ClassCounts& counts = counts_[dominant.key];
    // Single triangles are leaves only if others of them touch nothing.
    const bool repeated = (dominant.key.triangle_count > 1 ? counts.both : counts.alone) >= kRepeated;
    return !(repeated && dominant.part_count > 1 && dominant.share >= kAlikeShare);
  }

  bool has_many_of_each(TriangleList whole, const std::vector<std::vector<std::uint32_t>>& parts) const {
    constexpr std::size_t kMany = 4;
    constexpr double kShare = 0.4;
    std::map<ClassKey, std::vector<std::size_t>> sizes;
    for (const auto& part : parts) sizes[class_of(part)].push_back(part.size());
    std::size_t repeated = 0;
    for (const auto& [key, of] : sizes)
      if (of.size() >= kMany && key.triangle_count > 1) repeated += std::accumulate(of.begin(), of.end(), std::size_t{0});
    return static_cast<double>(repeated) >= kShare * static_cast<double>(whole.size());
  }

  bool are_alike(TriangleList piece, const std::vector<std::vector<std::uint32_t>>& parts) {
    const MainClass dominant = main_class(piece, parts);
    return dominant.part_count > 1 && dominant.share >= kAlikeShare && dominant.key.triangle_count > 1 &&
           counts_[dominant.key].by_edge >= kRepeated;
  }

  void choose_by_index(TriangleList part) {
    const auto index_parts = parts(part, by_index_);
    if (index_parts.size() > 1) {
      const MainClass dominant = main_class(part, index_parts);
      const ClassCounts& counts = counts_[dominant.key];
      if (dominant.share >= kSameShare && counts.alone >= kRepeated && 2 * counts.alone >= counts.by_index &&
          !has_repeated_triangles(part)) {
        for (const auto& index_part : index_parts) assign(index_part);
        return;
      }
    }
    assign(part);
  }

  /// Whether a leaf was modelled once per side: then its parts are alike too.
  bool has_repeated_triangles(TriangleList part) const {
    std::vector<std::array<std::uint32_t, 3>> sorted;
    for (const std::uint32_t t : part) {
      sorted.push_back(points_.of(t));
      std::ranges::sort(sorted.back());
    }
    std::ranges::sort(sorted);
    return std::ranges::adjacent_find(sorted) != sorted.end();
  }

  void assign(TriangleList piece) {
    for (const std::uint32_t t : piece) piece_of_[t] = piece[0];
  }

  const Mesh& mesh_;
  const Points& points_;
  TriangleList triangles_;
  UnionFind by_edge_, by_index_, both_, welded_;
  std::map<ClassKey, ClassCounts> counts_;
  std::vector<std::uint32_t> piece_of_;
};

/// Moves pieces without area to the collapsed triangles if they touch a piece that has some.
void take_thin_pieces(const Points& points, std::vector<std::uint32_t>& piece_of, std::vector<std::uint32_t>& whole,
                      std::vector<std::uint32_t>& collapsed) {
  std::vector<bool> has_area(piece_of.size(), false), seen(points.count(), false), touches(piece_of.size(), false);
  for (const std::uint32_t t : whole)
    if (points.has_area(t)) has_area[piece_of[t]] = true;
  for (const std::uint32_t t : whole)
    if (has_area[piece_of[t]])
      for (const std::uint32_t point : points.of(t)) seen[point] = true;
  for (const std::uint32_t t : whole)
    for (const std::uint32_t point : points.of(t))
      if (seen[point]) touches[piece_of[t]] = true;
  const auto is_seam = [&](std::uint32_t t) { return !has_area[piece_of[t]] && touches[piece_of[t]]; };
  std::ranges::copy_if(whole, std::back_inserter(collapsed), is_seam);
  std::ranges::sort(collapsed);
  std::erase_if(whole, is_seam);
}

/// Files collapsed triangles with the piece they touch, or as loose.
void file_collapsed(const Points& points, TriangleList collapsed, Pieces& pieces) {
  std::vector<std::uint32_t> piece_at(points.count(), kNone);
  for (std::size_t i = 0; i < pieces.ranges.size(); ++i)
    for (const std::uint32_t t : pieces.of(i))
      for (const std::uint32_t point : points.of(t))
        if (piece_at[point] == kNone) piece_at[point] = static_cast<std::uint32_t>(i);
  for (const std::uint32_t t : collapsed) {
    const auto corners = points.of(t);
    const auto touching = std::ranges::find_if(corners, [&](std::uint32_t point) { return piece_at[point] != kNone; });
    if (touching != corners.end()) {
      pieces.seams.push_back(t);
      pieces.seam_pieces.push_back(piece_at[*touching]);
      continue;
    }
    pieces.loose.push_back(t);
    pieces.loose_points.push_back(*std::ranges::min_element(corners));
  }
}

/// piece_of_triangles(points, triangles): [triangle count] the first triangle of each triangle's piece; kNone for those not in `triangles`
template <class PieceOf>
Pieces split_with(const Mesh& mesh, const std::vector<std::uint32_t>& welded, const PieceOf& piece_of_triangles) {
  const Points points(mesh, welded);
  std::vector<std::uint32_t> whole, collapsed;
  for (std::uint32_t t = 0; t < mesh.triangle_materials.size(); ++t) (points.is_collapsed(t) ? collapsed : whole).push_back(t);
  Pieces pieces;
  if (!whole.empty()) {
    std::vector<std::uint32_t> piece_of = piece_of_triangles(points, TriangleList(whole));
    take_thin_pieces(points, piece_of, whole, collapsed);
    static_cast<Groups&>(pieces) = group_by(whole, mesh.triangle_materials.size(), [&](std::uint32_t t) { return piece_of[t]; });
  }
  file_collapsed(points, collapsed, pieces);
  return pieces;
}

}  // namespace

Pieces split_pieces(const Mesh& mesh, const std::vector<std::uint32_t>& welded) {
  return split_with(mesh, welded, [&](const Points& points, TriangleList whole) {
    std::vector<std::uint32_t> piece_of = Splitter(mesh, points, whole).choose();
    join_lobes(mesh, points, piece_of);
    return piece_of;
  });
}

Pieces split_surfaces(const Mesh& mesh, const std::vector<std::uint32_t>& welded) {
  return split_with(mesh, welded, [&](const Points& points, TriangleList whole) {
    UnionFind by_edge(mesh.triangle_materials.size());
    join_edges(points, join_repeated(points, whole, by_edge), by_edge);
    std::vector<std::uint32_t> piece_of(mesh.triangle_materials.size(), kNone);
    for (const std::uint32_t t : whole) piece_of[t] = by_edge.find(t);
    return piece_of;
  });
}

std::vector<std::uint32_t> join_materials(const Mesh& mesh, const std::vector<std::uint32_t>& welded, const Pieces& pieces,
                                          const std::vector<bool>& candidates) {
  UnionFind sets(pieces.ranges.size());
  std::vector<Edge> edges;
  const bool one_material =
      std::ranges::adjacent_find(mesh.triangle_materials, std::ranges::not_equal_to{}) == mesh.triangle_materials.end();
  for (std::uint32_t i = 0; i < pieces.ranges.size() && !one_material; ++i)
    for (const std::uint32_t t : candidates[i] ? pieces.of(i) : TriangleList()) {
      const std::uint32_t* corners = &mesh.indices[3 * std::size_t{t}];
      for (std::size_t e = 0; e < 3; ++e) edges.push_back(edge_between(welded[corners[e]], welded[corners[(e + 1) % 3]], i));
    }
  std::ranges::sort(edges);
  const auto material = [&](std::uint32_t piece) { return mesh.triangle_materials[pieces.of(piece)[0]]; };
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const Edge &a = edges[i - 1], &b = edges[i];
    if (same_place(a, b) && material(a[2]) != material(b[2])) sets.join(a[2], b[2]);
  }
  std::vector<std::uint32_t> first(pieces.ranges.size());
  for (std::uint32_t i = 0; i < first.size(); ++i) first[i] = sets.find(i);
  return first;
}

}  // namespace coppice::bake
