#include "leaf_mesh_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"

namespace coppice::bake {
namespace {

/// Whether the diagonals halve each other: then either may be the edge.
bool is_parallelogram(const Quad& quad) {
  const glm::vec3 apart = quad[0] + quad[2] - quad[1] - quad[3];
  constexpr float kFlat = 1e-3f;
  return glm::length(apart) <= kFlat * std::max(glm::distance(quad[0], quad[2]), glm::distance(quad[1], quad[3]));
}

/// Whether a leaf is the two triangles of its quad.
bool is_quad(const Mesh& mesh, const LeafRange& leaf, const Quad& quad) {
  if (leaf.triangle_count != 2) return false;
  std::array<std::uint32_t, 4> uses{};
  for (const std::uint32_t vertex : leaf_indices(mesh, leaf)) {
    const auto corner = std::ranges::find(quad, mesh.positions[vertex]);
    if (corner == quad.end()) return false;
    ++uses[static_cast<std::size_t>(corner - quad.begin())];
  }
  const bool same_edge = uses[0] == 2 && uses[2] == 2;
  return std::ranges::count(uses, 0u) == 0 && (same_edge || is_parallelogram(quad));
}

/// Moves the bits of x to every third place.
std::uint64_t spread(std::uint64_t x) {
  std::uint64_t result = 0;
  for (std::uint32_t bit = 0; bit < 16; ++bit) result |= (x >> bit & 1u) << (3 * bit);
  return result;
}

/// Leaf numbers along a Morton curve through their stalks; leaves at one place keep leaf order.
std::vector<std::size_t> curve_order(const std::vector<Quad>& quads) {
  PointBox<glm::vec3> box;
  for (const Quad& quad : quads) box.add(quad[0]);
  const glm::vec3 extent = glm::max(box.extent(), glm::vec3(std::numeric_limits<float>::min()));
  std::vector<std::uint64_t> codes;
  for (const Quad& quad : quads) {
    const glm::vec3 place = glm::clamp((quad[0] - box.low) / extent, 0.0f, 1.0f) * 65535.0f;
    const auto step = [&](int axis) { return static_cast<std::uint64_t>(std::lround(place[axis])); };
    codes.push_back(spread(step(0)) | spread(step(1)) << 1 | spread(step(2)) << 2);
  }
  std::vector<std::size_t> order(quads.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t leaf) { return codes[leaf]; });
  return order;
}

/// Builds parts leaf by leaf. Vertices are shared within a leaf, as in the source.
class PartBuilder {
 public:
  explicit PartBuilder(const Mesh& source) : source_(source), leaf_of_(source.positions.size(), kNone), vertex_of_(leaf_of_.size()) {}

  void add(const LeafRange& leaf, const glm::vec3& stalk) {
    LeafMeshPart& part = parts.back();
    PointBox<glm::vec2> uvs;
    for (const std::uint32_t vertex : leaf_indices(source_, leaf)) uvs.add(source_.uvs[vertex]);
    const glm::vec2 shift = glm::floor(uvs.low);
    for (const std::uint32_t vertex : leaf_indices(source_, leaf)) {
      if (leaf_of_[vertex] != leaf.first_triangle) {
        leaf_of_[vertex] = leaf.first_triangle;
        vertex_of_[vertex] = static_cast<std::uint32_t>(part.mesh.positions.size());
        part.mesh.positions.push_back(source_.positions[vertex]);
        part.mesh.normals.push_back(source_.normals[vertex]);
        part.mesh.uvs.push_back(source_.uvs[vertex] - shift);
        part.stalks.push_back(stalk);
      }
      part.mesh.indices.push_back(vertex_of_[vertex]);
    }
    const auto first = source_.triangle_materials.begin() + std::ptrdiff_t{leaf.first_triangle};
    part.mesh.triangle_materials.insert(part.mesh.triangle_materials.end(), first, first + std::ptrdiff_t{leaf.triangle_count});
  }

  std::vector<LeafMeshPart> parts;

 private:
  const Mesh& source_;
  std::vector<std::uint32_t> leaf_of_;    ///< [vertex] first triangle of the last leaf that used it
  std::vector<std::uint32_t> vertex_of_;  ///< [vertex] its number in that leaf's part
};

KeptLeafMeshes too_large(std::uint64_t triangles) {
  return {{},
          "its leaves have " + std::to_string(triangles) + " triangles, more than a file keeps (" +
              std::to_string(std::uint64_t{COPPICE_MAX_LEAF_MESHES} * COPPICE_MAX_LEAF_MESH_TRIANGLES) + ")",
          true};
}

}  // namespace

KeptLeafMeshes keep_leaf_meshes(const Plant& plant, const Foliage& foliage) {
  if (plant.leaves.empty()) return {{}, "the plant has no leaves", false};
  bool all_quads = true;
  std::uint64_t triangles = 0;
  for (std::size_t i = 0; i < plant.leaves.size(); ++i) {
    all_quads = all_quads && is_quad(plant.foliage, plant.leaves[i], foliage.quads[i]);
    triangles += plant.leaves[i].triangle_count;
  }
  if (all_quads) return {{}, "its leaves are quads as they are", false};

  const std::uint64_t part_count = (triangles + COPPICE_MAX_LEAF_MESH_TRIANGLES - 1) / COPPICE_MAX_LEAF_MESH_TRIANGLES;
  const std::uint64_t fair_share = (triangles + part_count - 1) / part_count;
  PartBuilder builder(plant.foliage);
  std::uint64_t in_part = fair_share;  // counts as full, so that the first leaf starts a part
  for (const std::size_t leaf : curve_order(foliage.quads)) {
    const std::uint64_t more = plant.leaves[leaf].triangle_count;
    if (more > COPPICE_MAX_LEAF_MESH_TRIANGLES) return too_large(triangles);
    if (in_part >= fair_share || in_part + more > COPPICE_MAX_LEAF_MESH_TRIANGLES) {
      if (builder.parts.size() == COPPICE_MAX_LEAF_MESHES) return too_large(triangles);
      builder.parts.emplace_back();
      in_part = 0;
    }
    builder.add(plant.leaves[leaf], foliage.quads[leaf][0]);
    in_part += more;
  }
  return {{std::move(builder.parts), {}}, {}, false};
}

Mesh whole_leaf_mesh(const LeafMeshes& meshes) {
  Mesh whole;
  for (const LeafMeshPart& part : meshes.parts) {
    const auto first = static_cast<std::uint32_t>(whole.positions.size());
    whole.positions.insert(whole.positions.end(), part.mesh.positions.begin(), part.mesh.positions.end());
    whole.normals.insert(whole.normals.end(), part.mesh.normals.begin(), part.mesh.normals.end());
    whole.uvs.insert(whole.uvs.end(), part.mesh.uvs.begin(), part.mesh.uvs.end());
    for (const std::uint32_t index : part.mesh.indices) whole.indices.push_back(first + index);
    whole.triangle_materials.insert(whole.triangle_materials.end(), part.mesh.triangle_materials.begin(),
                                    part.mesh.triangle_materials.end());
  }
  return whole;
}

std::uint32_t triangle_count(const LeafMeshes& meshes) {
  std::size_t count = 0;
  for (const LeafMeshPart& part : meshes.parts) count += part.mesh.triangle_materials.size();
  return static_cast<std::uint32_t>(count);
}

}  // namespace coppice::bake
