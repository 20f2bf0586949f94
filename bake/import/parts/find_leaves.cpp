#include "find_leaves.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <span>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "leaf_evidence.h"
#include "leaf_pieces.h"
#include "material_words.h"
#include "parallel_for.h"
#include "piece_shape.h"
#include "weld.h"

namespace coppice::bake {
namespace {

double box_diagonal_m(const Mesh& mesh) {
  if (mesh.positions.empty()) return 0.0;
  glm::dvec3 low(mesh.positions[0]), high(mesh.positions[0]);
  for (const glm::vec3& position : mesh.positions) {
    low = glm::min(low, glm::dvec3(position));
    high = glm::max(high, glm::dvec3(position));
  }
  return glm::distance(low, high);
}

std::vector<PieceShape> measure_pieces(const Mesh& mesh, const Pieces& pieces) {
  std::vector<PieceShape> shapes(pieces.ranges.size());
  // Each piece writes its own slot, so the result does not depend on the threads.
  constexpr std::size_t kGrain = 64;
  parallel_for(
      shapes.size(),
      [&](std::size_t i) {
        const LeafRange& range = pieces.ranges[i];
        shapes[i] = measure_piece(mesh, std::span(pieces.triangles).subspan(range.first_triangle, range.triangle_count));
      },
      kGrain);
  return shapes;
}

/// [material] What becomes of its triangles without area: they are dropped if it is foliage.
std::vector<PlantPart> parts_without_area(const std::vector<PieceClass>& classes, const std::vector<Material>& materials,
                                          const std::vector<std::vector<MaterialRule>>& rules) {
  std::vector<std::uint32_t> leaf_counts(materials.size(), 0), other_counts(materials.size(), 0);
  for (const PieceClass& each : classes) (each.part == PlantPart::wood ? other_counts : leaf_counts)[each.material] += each.piece_count;
  std::vector<PlantPart> parts;
  parts.reserve(materials.size());
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const bool unseen = leaf_counts[m] + other_counts[m] == 0;
    const bool foliage = !unseen            ? leaf_counts[m] > other_counts[m]
                         : rules[m].empty() ? name_evidence(materials[m].name) > 0.0
                                            : rules[m].front().part != PlantPart::wood;
    parts.push_back(foliage ? PlantPart::dropped : PlantPart::wood);
  }
  return parts;
}

/// The state of one call.
struct Finder {
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
  const std::vector<std::vector<MaterialRule>>& rules;
  Mesh mesh;  ///< welded positions are equal
  std::vector<glm::vec3> source_positions;
  std::vector<std::uint32_t> welded;
  Pieces pieces;
  ClassedPieces classed;
  std::vector<PlantPart> without_area;  ///< by material

  [[nodiscard]] std::uint32_t material_of(std::size_t triangle) const { return mesh.triangle_materials[triangle]; }
  [[nodiscard]] std::uint32_t piece_material(std::size_t piece) const {
    return material_of(pieces.triangles[pieces.ranges[piece].first_triangle]);
  }
  [[nodiscard]] std::span<const std::uint32_t> piece_triangles(std::size_t piece) const {
    return std::span(pieces.triangles).subspan(pieces.ranges[piece].first_triangle, pieces.ranges[piece].triangle_count);
  }
  [[nodiscard]] PlantPart piece_part(std::size_t piece) const {
    const std::uint32_t of = classed.class_of[piece];
    return of == kNone ? without_area[piece_material(piece)] : classed.classes[of].part;
  }

  void weld_positions(const std::vector<std::uint32_t>& instances) {
    welded = weld(mesh.positions, instances);
    source_positions = mesh.positions;
    for (std::size_t i = 0; i < welded.size(); ++i) mesh.positions[i] = source_positions[welded[i]];
  }

  [[nodiscard]] bool has_leaves() const {
    return std::ranges::any_of(classed.classes, [](const PieceClass& each) { return each.part == PlantPart::leaf; });
  }

  /// Makes leaves of sheets if nothing else is a leaf; if there are no sheets, of those that grow out of common points.
  void look_for_sheets() {
    if (judge_sheets(classed)) return;
    Pieces whole = std::exchange(pieces, split_surfaces(mesh, welded));
    if (pieces.ranges.size() > whole.ranges.size()) {
      ClassedPieces before = classed;
      judge_pieces();
      if (has_leaves() || judge_sheets(classed)) return;
      classed = std::move(before);
    }
    pieces = std::move(whole);
  }

  void judge_pieces() {
    const double extent_m = box_diagonal_m(mesh);
    const std::vector<PieceShape> shapes = measure_pieces(mesh, pieces);
    // It is no wider than the weld tolerance: rounding made it, or it fills a T-junction.
    const double tolerance_m = extent_m * static_cast<double>(kWeldTolerance);
    std::vector<bool> left_out(shapes.size());
    for (std::size_t i = 0; i < shapes.size(); ++i)
      left_out[i] = shapes[i].area_m2 <= tolerance_m * std::max(tolerance_m, shapes[i].length_m);
    classed = class_pieces(mesh, pieces, shapes, left_out);
    judge_classes({mesh, pieces, materials, images, extent_m}, rules, classed);
  }

  void take_leaves(FoundParts& found) const {
    std::vector<bool> is_leaf(pieces.ranges.size());
    for (std::size_t i = 0; i < is_leaf.size(); ++i) is_leaf[i] = piece_part(i) == PlantPart::leaf;
    const std::vector<std::uint32_t> first_piece = join_materials(mesh, welded, pieces, is_leaf);
    std::vector<std::vector<std::uint32_t>> leaves(pieces.ranges.size());
    for (std::size_t i = 0; i < is_leaf.size(); ++i)
      if (is_leaf[i]) {
        const auto triangles = piece_triangles(i);
        leaves[first_piece[i]].insert(leaves[first_piece[i]].end(), triangles.begin(), triangles.end());
      }
    Mesh sorted = {mesh.positions, mesh.normals, mesh.uvs, {}, {}};
    sorted.wind_weights = mesh.wind_weights;
    for (const auto& leaf : leaves) {
      if (leaf.empty()) continue;
      found.leaves.push_back({static_cast<std::uint32_t>(sorted.triangle_materials.size()), static_cast<std::uint32_t>(leaf.size())});
      for (const std::uint32_t t : leaf) append_triangle(t, sorted);
    }
    found.foliage = compact(sorted);
  }

  void append_triangle(std::uint32_t triangle, Mesh& to) const {
    for (std::size_t k = 0; k < 3; ++k) to.indices.push_back(mesh.indices[3 * std::size_t{triangle} + k]);
    to.triangle_materials.push_back(mesh.triangle_materials[triangle]);
    if (!mesh.triangle_tints.empty()) to.triangle_tints.push_back(mesh.triangle_tints[triangle]);
  }

  void take_wood(FoundParts& found) const {
    std::vector<bool> is_wood(mesh.triangle_materials.size(), false);
    for (std::size_t i = 0; i < pieces.ranges.size(); ++i)
      for (const std::uint32_t t : piece_triangles(i)) is_wood[t] = piece_part(i) == PlantPart::wood;
    for (std::size_t i = 0; i < pieces.seams.size(); ++i) is_wood[pieces.seams[i]] = piece_part(pieces.seam_pieces[i]) == PlantPart::wood;
    for (const std::uint32_t t : pieces.loose) is_wood[t] = without_area[material_of(t)] == PlantPart::wood;
    Mesh wood = {source_positions, mesh.normals, mesh.uvs, {}, {}};
    wood.wind_weights = mesh.wind_weights;
    for (std::uint32_t t = 0; t < is_wood.size(); ++t)
      if (is_wood[t]) append_triangle(t, wood);
    found.wood = compact(wood);
    turn_to_normals(found.wood);
  }

  /// Counts dropped leaves without area, and adds a class for them to each material.
  void count_dropped(FoundParts& found) const {
    std::vector<PieceClass> dropped(materials.size());
    for (std::size_t i = 0; i < pieces.ranges.size(); ++i)
      if (classed.class_of[i] == kNone && piece_part(i) == PlantPart::dropped) {
        ++dropped[piece_material(i)].piece_count;
        dropped[piece_material(i)].total_triangles += pieces.ranges[i].triangle_count;
      }
    std::set<std::uint32_t> counted;
    for (std::size_t i = 0; i < pieces.loose.size(); ++i) {
      const std::uint32_t material = material_of(pieces.loose[i]);
      if (without_area[material] != PlantPart::dropped) continue;
      ++dropped[material].total_triangles;
      if (counted.insert(pieces.loose_numbers[i]).second) ++dropped[material].piece_count;
    }
    for (std::uint32_t m = 0; m < dropped.size(); ++m) {
      if (dropped[m].piece_count == 0) continue;
      found.dropped_leaf_count += dropped[m].piece_count;
      dropped[m].material = m;
      dropped[m].part = PlantPart::dropped;
      dropped[m].reason = "no area";
      found.classes.push_back(std::move(dropped[m]));
    }
    std::ranges::stable_sort(found.classes, {}, [](const PieceClass& each) { return each.material; });
  }
};

}  // namespace

FoundParts find_leaves(TriangleSoup soup, const std::vector<Material>& materials, const std::vector<Image>& images,
                       const std::vector<std::vector<MaterialRule>>& rules) {
  Finder finder{materials, images, rules, std::move(soup.mesh), {}, {}, {}, {}, {}};
  finder.weld_positions(soup.vertex_instances);
  finder.pieces = split_pieces(finder.mesh, finder.welded);
  finder.judge_pieces();
  if (!finder.has_leaves()) finder.look_for_sheets();
  finder.without_area = parts_without_area(finder.classed.classes, materials, rules);
  FoundParts found;
  finder.take_leaves(found);
  finder.take_wood(found);
  found.classes = std::move(finder.classed.classes);
  finder.count_dropped(found);
  return found;
}

}  // namespace coppice::bake
