#include "wood_lods.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include <meshoptimizer.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "gltf_triangles.h"
#include "union_find.h"
#include "weld.h"

namespace coppice::bake {
namespace {

// Wood is tubes: a trunk, boughs, twigs, each its own connected piece of surface. A simplifier set on all of it at once stalls when every
// twig is a prism (edge collapse: 905 triangles of eztree_oak_medium's 3,166, however few are asked for) or loses what is thinner than its
// grid, which is the trunk (vertex clustering). So each LoD keeps the weightiest pieces and simplifies each by itself: twigs go first, the
// trunk stays.

constexpr std::size_t kMaxLods = 7;
constexpr std::size_t kReduction = 4;
// Of a wood with fewer triangles than this no coarser LoD is made: there is nothing left to save.
constexpr std::size_t kLeastTriangles = 96;
// A prism of three sides.
constexpr std::size_t kTubeTriangles = 6;
// Edge collapse that leaves more than this many times what was asked for has stalled; the coarsest clustering that keeps this share of the
// piece's area may take its place, if it leaves fewer.
constexpr std::size_t kStalled = 2;
constexpr double kLeastClusteredArea = 0.7;
// A piece is squeezed to no less than this share of its length, so that its cells stay some vertices long.
constexpr double kLeastSqueeze = 0.01;
// Pieces that will not go below their share may make a LoD this much larger than asked for; beyond that the lighter ones are left out.
constexpr double kOverdraw = 1.25;
// A LoD with more than this share of the one before is not worth its bytes.
constexpr double kLeastProgress = 0.7;
// Errors are relative to a piece's extent; this is no limit.
constexpr float kAnyError = 1.0f;

using Indices = std::vector<std::uint32_t>;

/// A connected piece of wood of one material.
struct Piece {
  std::uint32_t material = 0;
  Indices vertices;                  ///< in the source mesh
  std::vector<glm::vec3> positions;  ///< of those
  Indices indices;                   ///< into `vertices`
  std::vector<glm::vec3> squeezed;   ///< the positions, along the piece's length as much drawn together as it is longer than thick
  double area_m2 = 0.0;
  double weight = 0.0;  ///< how much it matters from afar: area times girth
  [[nodiscard]] std::size_t triangle_count() const { return indices.size() / 3; }
};

double area_m2(const std::vector<glm::vec3>& positions, const Indices& indices) {
  double area = 0.0;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const glm::dvec3 a(positions[indices[i]]), b(positions[indices[i + 1]]), c(positions[indices[i + 2]]);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area;
}

/// Where the piece's area is, how much of it, and how it spreads.
struct Spread {
  glm::dvec3 center{0.0};
  glm::dvec3 along{0.0, 1.0, 0.0};  ///< the direction it spreads most in
  double slenderness = 1.0;         ///< spread across, by spread along
};

Spread spread_of(const Piece& piece) {
  std::vector<std::pair<glm::dvec3, double>> samples;  // centre and area of each triangle
  Spread spread;
  double area = 0.0;
  for (std::size_t i = 0; i < piece.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) { return glm::dvec3(piece.positions[piece.indices[i + k]]); };
    const glm::dvec3 a = corner(0), b = corner(1), c = corner(2);
    samples.emplace_back((a + b + c) / 3.0, 0.5 * glm::length(glm::cross(b - a, c - a)));
    spread.center += samples.back().first * samples.back().second;
    area += samples.back().second;
  }
  if (!(area > 0.0)) return spread;
  spread.center /= area;
  // Power iteration on the covariance, from a direction that no axis is across.
  constexpr int kIterations = 50;
  glm::dvec3 along = glm::normalize(glm::dvec3(0.3, 1.0, 0.2));
  for (int i = 0; i < kIterations; ++i) {
    glm::dvec3 next(0.0);
    for (const auto& [point, weight] : samples) next += weight * glm::dot(point - spread.center, along) * (point - spread.center);
    if (!(glm::length(next) > 0.0)) return spread;
    along = glm::normalize(next);
  }
  double squares_along = 0.0, squares = 0.0;
  for (const auto& [point, weight] : samples) {
    const glm::dvec3 arm = point - spread.center;
    squares += weight * glm::dot(arm, arm);
    squares_along += weight * glm::dot(arm, along) * glm::dot(arm, along);
  }
  spread.along = along;
  spread.slenderness = std::sqrt(std::max(squares - squares_along, 0.0) / (2.0 * squares_along));
  return spread;
}

/// Cells of a clustering are cubes: in the plant's proportions they are longer than a trunk is thick long before they are as long as its
/// sections. Squeezed, a tube of a few sections is a few cells.
void squeeze(Piece& piece) {
  const Spread spread = spread_of(piece);
  const double factor = std::clamp(spread.slenderness, kLeastSqueeze, 1.0);
  for (const glm::vec3& position : piece.positions) {
    const glm::dvec3 arm = glm::dvec3(position) - spread.center;
    piece.squeezed.emplace_back(arm + spread.along * (glm::dot(arm, spread.along) * (factor - 1.0)));
  }
}

/// By area alone, the short pieces of coffee.glb's trunk come after its long thin boughs. The girth of a tube is its area by its length.
void weigh(Piece& piece) {
  piece.area_m2 = area_m2(piece.positions, piece.indices);
  glm::vec3 low = piece.positions.front(), high = low;
  for (const glm::vec3& position : piece.positions) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  const double length_m = glm::distance(glm::dvec3(low), glm::dvec3(high));
  piece.weight = length_m > 0.0 ? piece.area_m2 * piece.area_m2 / length_m : 0.0;
}

/// The pieces, the weightiest first.
std::vector<Piece> split_pieces(const Mesh& wood) {
  const std::vector<std::uint32_t> one_group(wood.positions.size(), 0);
  const std::vector<std::uint32_t> welded = weld(wood.positions, one_group);
  UnionFind sets(welded.size());
  for (std::size_t i = 0; i < wood.indices.size(); i += 3)
    for (std::size_t k = 1; k < 3; ++k) sets.join(welded[wood.indices[i]], welded[wood.indices[i + k]]);

  std::vector<Piece> pieces;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> piece_of;  // by set and material
  std::vector<std::uint32_t> local(wood.positions.size(), kNone), local_piece(wood.positions.size(), kNone);
  for (std::size_t i = 0; i < wood.indices.size(); ++i) {
    const std::uint32_t vertex = wood.indices[i], material = wood.triangle_materials[i / 3];
    const auto [found, is_new] = piece_of.try_emplace({sets.find(welded[wood.indices[i]]), material}, pieces.size());
    if (is_new) pieces.emplace_back().material = material;
    Piece& piece = pieces[found->second];
    if (local_piece[vertex] != found->second) {
      local_piece[vertex] = static_cast<std::uint32_t>(found->second);
      local[vertex] = static_cast<std::uint32_t>(piece.vertices.size());
      piece.vertices.push_back(vertex);
      piece.positions.push_back(wood.positions[vertex]);
    }
    piece.indices.push_back(local[vertex]);
  }
  for (Piece& piece : pieces) weigh(piece);
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.weight > b.weight; });
  return pieces;
}

Indices collapse_edges(const Piece& piece, std::size_t target_count) {
  Indices result(piece.indices.size());
  result.resize(meshopt_simplify(result.data(), piece.indices.data(), piece.indices.size(), &piece.positions[0].x, piece.positions.size(),
                                 sizeof(glm::vec3), 3 * target_count, kAnyError, 0, nullptr));
  return result;
}

Indices cluster_vertices(const Piece& piece, std::size_t target_count) {
  Indices result(piece.indices.size());
  result.resize(meshopt_simplifySloppy(result.data(), piece.indices.data(), piece.indices.size(), &piece.squeezed[0].x,
                                       piece.squeezed.size(), sizeof(glm::vec3), 3 * target_count, kAnyError, nullptr));
  return result;
}

/// The piece's triangles, about target_count of them or as few as it can be had in, as vertices of the source. Never none.
Indices simplify_piece(Piece& piece, std::size_t target_count) {
  Indices simplified = piece.indices;
  if (target_count < piece.triangle_count()) {
    Indices collapsed = collapse_edges(piece, target_count);
    if (!collapsed.empty()) simplified = std::move(collapsed);
  }
  const std::size_t collapsed_count = simplified.size() / 3;
  if (collapsed_count > kStalled * target_count) {
    if (piece.squeezed.empty()) squeeze(piece);
    for (std::size_t count = target_count; count < collapsed_count; count *= 2) {
      Indices clustered = cluster_vertices(piece, count);
      if (clustered.empty() || area_m2(piece.positions, clustered) < kLeastClusteredArea * piece.area_m2) continue;
      if (clustered.size() < simplified.size()) simplified = std::move(clustered);
      break;
    }
  }
  for (std::uint32_t& index : simplified) index = piece.vertices[index];
  return simplified;
}

/// Triangles of a LoD, by material.
using Parts = std::map<std::uint32_t, Indices>;

/// About target_count triangles: half of them for as many of the weightiest pieces as can be prisms, half shared among those by area. The
/// weightiest piece of each material stays in any case.
Parts simplify_pieces(std::vector<Piece>& pieces, std::size_t target_count) {
  const std::size_t kept_count = std::clamp<std::size_t>(target_count / (2 * kTubeTriangles), 1, pieces.size());
  double kept_m2 = 0.0;
  for (std::size_t i = 0; i < kept_count; ++i) kept_m2 += pieces[i].area_m2;
  const double shared_count = std::max(static_cast<double>(target_count) - static_cast<double>(kTubeTriangles * kept_count), 0.0);
  const auto most_indices = static_cast<std::size_t>(3.0 * kOverdraw * static_cast<double>(target_count));
  Parts parts;
  std::size_t index_count = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const bool kept = i < kept_count;
    const double share = kept && kept_m2 > 0.0 ? shared_count * pieces[i].area_m2 / kept_m2 : 0.0;
    const bool is_first = parts.count(pieces[i].material) == 0;
    if (!kept && !is_first) continue;
    const Indices indices = simplify_piece(pieces[i], kTubeTriangles + static_cast<std::size_t>(share));
    if (!is_first && index_count + indices.size() > most_indices) continue;
    index_count += indices.size();
    Indices& part = parts[pieces[i].material];
    part.insert(part.end(), indices.begin(), indices.end());
  }
  return parts;
}

std::size_t triangle_count(const Parts& parts) {
  return std::accumulate(parts.begin(), parts.end(), std::size_t{0},
                         [](std::size_t sum, const auto& part) { return sum + part.second.size() / 3; });
}

/// One mesh of all parts, in the order in which a GPU's vertex cache likes them.
Mesh merge(const Mesh& source, const Parts& parts) {
  Mesh merged;
  merged.positions = source.positions;
  merged.normals = source.normals;
  merged.uvs = source.uvs;
  for (const auto& [material, indices] : parts) {
    Indices ordered(indices.size());
    meshopt_optimizeVertexCache(ordered.data(), indices.data(), indices.size(), source.positions.size());
    merged.indices.insert(merged.indices.end(), ordered.begin(), ordered.end());
    merged.triangle_materials.resize(merged.indices.size() / 3, material);
  }
  return compact(merged);
}

Parts split_by_material(const Mesh& mesh) {
  Parts parts;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) parts[mesh.triangle_materials[i / 3]].push_back(mesh.indices[i]);
  return parts;
}

}  // namespace

Mesh halve_wood(const Mesh& wood) {
  Parts parts = split_by_material(wood);
  for (auto& [material, indices] : parts) {
    const std::size_t target_count = std::max<std::size_t>(indices.size() / 6, 1);
    Indices clustered(indices.size());
    clustered.resize(meshopt_simplifySloppy(clustered.data(), indices.data(), indices.size(), &wood.positions[0].x, wood.positions.size(),
                                            sizeof(glm::vec3), 3 * target_count, kAnyError, nullptr));
    // Wood that is all crumbs may vanish in the clusters; the first of them stay.
    if (clustered.empty()) clustered.assign(indices.begin(), indices.begin() + static_cast<std::ptrdiff_t>(3 * target_count));
    indices = std::move(clustered);
  }
  return merge(wood, parts);
}

WoodLods simplify_wood(const Mesh& wood) {
  WoodLods chain;
  if (wood.indices.empty()) return chain;
  std::vector<Piece> pieces = split_pieces(wood);
  chain.lods.push_back(merge(wood, split_by_material(wood)));
  std::size_t target_count = wood.triangle_materials.size() / kReduction;
  while (chain.lods.size() < kMaxLods && chain.lods.back().triangle_materials.size() > kLeastTriangles) {
    const Parts parts = simplify_pieces(pieces, target_count);
    const double share = static_cast<double>(triangle_count(parts)) / static_cast<double>(chain.lods.back().triangle_materials.size());
    if (share <= kLeastProgress) chain.lods.push_back(merge(wood, parts));
    target_count /= kReduction;
    if (target_count < kTubeTriangles) break;
  }
  return chain;
}

}  // namespace coppice::bake
