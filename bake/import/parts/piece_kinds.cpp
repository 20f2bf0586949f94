#include "piece_kinds.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "union_find.h"

namespace coppice::bake {
namespace {

using Features = std::vector<float>;

// Maximum number of groups that are compared; a piece that differs from all of them is no copy.
constexpr std::size_t kMaxLeaders = 64;
// Share of the pieces that must be in repeated groups.
constexpr double kGroupedShare = 0.8;

float largest_difference(const Features& a, const Features& b) {
  float largest = 0.0f;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// Groups features that are connected by steps within a tolerance. returns  [features.size()] the group of each, kNone if it is not
/// repeated; empty if few groups do not hold them
std::vector<std::uint32_t> group_features(const std::vector<Features>& features, float tolerance) {
  std::vector<const Features*> leaders;
  UnionFind connected(kMaxLeaders);
  std::vector<std::uint32_t> group_of;
  for (const Features& each : features) {
    std::uint32_t nearest = kNone;
    for (std::uint32_t i = 0; i < leaders.size(); ++i) {
      if (largest_difference(*leaders[i], each) > tolerance) continue;
      if (nearest != kNone) connected.join(nearest, i);
      if (nearest == kNone) nearest = i;
    }
    if (nearest == kNone && leaders.size() < kMaxLeaders) {
      nearest = static_cast<std::uint32_t>(leaders.size());
      leaders.push_back(&each);
    }
    group_of.push_back(nearest);
  }
  std::vector<std::size_t> counts(kMaxLeaders, 0);
  for (std::uint32_t& group : group_of)
    if (group != kNone) ++counts[group = connected.find(group)];
  for (std::uint32_t& group : group_of)
    if (group != kNone && counts[group] < kRepeated) group = kNone;
  const auto grouped = static_cast<double>(features.size()) - static_cast<double>(std::ranges::count(group_of, kNone));
  if (grouped < kGroupedShare * static_cast<double>(features.size())) return {};
  return group_of;
}

/// Pairs of point numbers that are an edge of some triangle.
std::vector<std::array<std::uint32_t, 2>> edges_of(const NumberedPiece& piece) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (std::size_t i = 0; i < piece.corners.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = piece.corners[i + k], b = piece.corners[i + (k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b)});
    }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// Lengths of edges over their root mean square. Place, direction, size and bends along edges do not change them.
Features proportions(const Mesh& mesh, const NumberedPiece& piece, const std::vector<std::array<std::uint32_t, 2>>& edges) {
  Features lengths;
  double sum = 0.0;
  for (const auto& [a, b] : edges) {
    lengths.push_back(glm::distance(mesh.positions[piece.vertices[a]], mesh.positions[piece.vertices[b]]));
    sum += static_cast<double>(lengths.back()) * static_cast<double>(lengths.back());
  }
  const auto scale = static_cast<float>(std::sqrt(sum / static_cast<double>(edges.size())));
  for (float& length : lengths) length /= scale > 0.0f ? scale : 1.0f;
  return lengths;
}

/// Texture coordinates, shifted by whole numbers to start in 0..1.
Features image_part(const Mesh& mesh, const NumberedPiece& piece) {
  glm::vec2 low = mesh.uvs[piece.vertices[0]];
  for (const std::uint32_t vertex : piece.vertices) low = glm::min(low, mesh.uvs[vertex]);
  // A coordinate a hair below a whole number counts as that number.
  const glm::vec2 shift = glm::floor(low + 1e-4f);
  Features part;
  for (const std::uint32_t vertex : piece.vertices) {
    part.push_back(mesh.uvs[vertex].x - shift.x);
    part.push_back(mesh.uvs[vertex].y - shift.y);
  }
  return part;
}

/// The longer side of the part of the image; 0 if it is a line.
float extent(const Features& image_part) {
  glm::vec2 low(image_part[0], image_part[1]), high = low;
  for (std::size_t i = 0; i < image_part.size(); i += 2) {
    low = glm::min(low, {image_part[i], image_part[i + 1]});
    high = glm::max(high, {image_part[i], image_part[i + 1]});
  }
  const glm::vec2 sides = high - low;
  return std::min(sides.x, sides.y) > 1e-4f ? std::max(sides.x, sides.y) : 0.0f;
}

/// Numbers the points by their distances from the others, and sorts the triangles, so that copies whose triangles come in any order compare
/// equal.
void renumber_by_form(const Mesh& mesh, NumberedPiece& piece) {
  const std::size_t count = piece.vertices.size();
  std::vector<std::pair<double, std::uint32_t>> order;
  for (std::uint32_t i = 0; i < count; ++i) {
    double sum = 0.0;
    for (std::uint32_t k = 0; k < count; ++k)
      sum += static_cast<double>(glm::distance(mesh.positions[piece.vertices[i]], mesh.positions[piece.vertices[k]]));
    order.emplace_back(sum, i);
  }
  std::ranges::sort(order);
  std::vector<std::uint32_t> new_number(count);
  NumberedPiece sorted = piece;
  for (std::uint32_t i = 0; i < count; ++i) {
    new_number[order[i].second] = i;
    sorted.points[i] = piece.points[order[i].second];
    sorted.vertices[i] = piece.vertices[order[i].second];
  }
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::size_t t = 0; t < piece.corners.size(); t += 3) {
    triangles.push_back({new_number[piece.corners[t]], new_number[piece.corners[t + 1]], new_number[piece.corners[t + 2]]});
    std::ranges::sort(triangles.back());
  }
  std::ranges::sort(triangles);
  sorted.corners.clear();
  for (const auto& triangle : triangles) sorted.corners.insert(sorted.corners.end(), triangle.begin(), triangle.end());
  piece = std::move(sorted);
}

using Size = std::array<std::size_t, 3>;
Size size_of(const Mesh& mesh, const NumberedPiece& piece) {
  return {mesh.triangle_materials[piece.first_triangle], piece.corners.size(), piece.points.size()};
}

/// Renumbers pieces of sizes whose triangles come in many orders.
void undo_reordering(const Mesh& mesh, std::vector<NumberedPiece>& pieces) {
  constexpr std::size_t kMaxOrders = 6;
  std::map<Size, std::set<std::vector<std::uint32_t>>> orders;
  for (const NumberedPiece& piece : pieces) {
    auto& of = orders[size_of(mesh, piece)];
    if (of.size() <= kMaxOrders) of.insert(piece.corners);
  }
  for (NumberedPiece& piece : pieces)
    if (orders[size_of(mesh, piece)].size() > kMaxOrders) renumber_by_form(mesh, piece);
}

/// Numbers topologies; [topology] its pieces.
std::vector<std::vector<std::uint32_t>> number_topologies(const Mesh& mesh, std::vector<NumberedPiece>& pieces) {
  std::map<std::pair<std::uint32_t, std::vector<std::uint32_t>>, std::uint32_t> numbers;
  std::vector<std::vector<std::uint32_t>> members;
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    const auto [found, is_new] = numbers.try_emplace({mesh.triangle_materials[pieces[i].first_triangle], pieces[i].corners},
                                                     static_cast<std::uint32_t>(members.size()));
    if (is_new) members.emplace_back();
    pieces[i].topology = found->second;
    members[found->second].push_back(i);
  }
  return members;
}

PieceShape shape_of(const Mesh& mesh, const NumberedPiece& piece) {
  Mesh alone;
  for (const std::uint32_t vertex : piece.vertices) alone.positions.push_back(mesh.positions[vertex]);
  alone.indices = piece.corners;
  std::vector<std::uint32_t> triangles(piece.corners.size() / 3);
  std::iota(triangles.begin(), triangles.end(), 0u);
  return measure_piece(alone, triangles);
}

/// Groups pieces by the part of the image that they show; empty if they show none, or each its own.
std::vector<std::uint32_t> group_by_image(const Mesh& mesh, const std::vector<NumberedPiece>& pieces,
                                          const std::vector<std::uint32_t>& members) {
  std::vector<Features> parts;
  float smallest = 1.0f;
  for (const std::uint32_t i : members) {
    parts.push_back(image_part(mesh, pieces[i]));
    smallest = std::min(smallest, extent(parts.back()));
  }
  if (smallest == 0.0f) return {};
  return group_features(parts, 0.03f * smallest);
}

std::vector<std::uint32_t> group_by_form(const Mesh& mesh, const std::vector<NumberedPiece>& pieces,
                                         const std::vector<std::uint32_t>& members, float tolerance) {
  const auto edges = edges_of(pieces[members[0]]);
  std::vector<Features> forms;
  forms.reserve(members.size());
  for (const std::uint32_t i : members) forms.push_back(proportions(mesh, pieces[i], edges));
  return group_features(forms, tolerance);
}

void add_kinds(const Mesh& mesh, std::vector<NumberedPiece>& pieces, const std::vector<std::uint32_t>& members, KindTable& table) {
  // A leaf that was stretched shows the same part of the image; only a clearly different form makes it another kind.
  constexpr float kFormTolerance = 0.06f, kSameImageTolerance = 0.12f;
  const auto part_of = group_by_image(mesh, pieces, members);
  const auto form_of = group_by_form(mesh, pieces, members, part_of.empty() ? kFormTolerance : kSameImageTolerance);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> numbers;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const std::uint32_t part = part_of.empty() ? 0 : part_of[i], form = form_of.empty() ? 0 : form_of[i];
    if (part == kNone || form == kNone) continue;
    const auto [found, is_new] = numbers.try_emplace({part, form}, static_cast<std::uint32_t>(table.kinds.size()));
    if (is_new) table.kinds.push_back({shape_of(mesh, pieces[members[i]]), !part_of.empty()});
    pieces[members[i]].kind = found->second;
    ++table.kinds[found->second].count;
  }
}

}  // namespace

NumberedPiece number_piece(const Mesh& mesh, const Points& points, std::span<const std::uint32_t> triangles) {
  NumberedPiece piece;
  piece.first_triangle = triangles[0];
  std::vector<std::array<std::uint32_t, 3>> seen;
  for (const std::uint32_t t : triangles) {
    if (!points.has_area(t)) continue;
    const auto corners = points.of(t);
    auto sorted = corners;
    std::ranges::sort(sorted);
    if (std::ranges::find(seen, sorted) != seen.end()) continue;
    seen.push_back(sorted);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = std::ranges::find(piece.points, corners[k]);
      piece.corners.push_back(static_cast<std::uint32_t>(found - piece.points.begin()));
      if (found != piece.points.end()) continue;
      piece.points.push_back(corners[k]);
      piece.vertices.push_back(mesh.indices[3 * std::size_t{t} + k]);
    }
  }
  return piece;
}

KindTable find_kinds(const Mesh& mesh, std::vector<NumberedPiece>& pieces) {
  undo_reordering(mesh, pieces);
  KindTable table;
  for (const auto& members : number_topologies(mesh, pieces)) {
    table.topology_counts.push_back(static_cast<std::uint32_t>(members.size()));
    if (members.size() >= kRepeated && !pieces[members[0]].corners.empty()) add_kinds(mesh, pieces, members, table);
  }
  return table;
}

}  // namespace coppice::bake
