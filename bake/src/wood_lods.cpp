#include "wood_lods.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <meshoptimizer.h>

#include "gltf_triangles.h"

namespace coppice::bake {
namespace {

// Each LoD is simplified from the source by two algorithms, and the one that strays less wins: edge collapse, which keeps topology, normals
// and seams but stalls once every twig is a prism, and vertex clustering ("sloppy"), which gets as low as asked. Edge collapse pushed past
// its stall flattens twigs: of scopia_bush at 209 triangles it leaves 20 % of the area, clustering 61 %.

constexpr std::size_t kMaxLods = 5;
constexpr std::size_t kReduction = 4;
// Of a wood with fewer triangles than this no coarser LoD is made: there is nothing left to save.
constexpr std::size_t kLeastTriangles = 96;
// What a simplifier may miss its target by and still be said to have reached it.
constexpr double kSlack = 1.25;
// A LoD with more than this share of the one before is not worth its bytes.
constexpr double kLeastProgress = 0.7;
// Both errors are relative to the wood's extent; this is no limit.
constexpr float kAnyError = 1.0f;

using Indices = std::vector<std::uint32_t>;

/// The triangles of one material.
struct Part {
  std::uint32_t material = 0;
  Indices indices;
};

std::vector<Part> split_by_material(const Mesh& mesh) {
  std::vector<Part> parts;
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    const std::uint32_t material = mesh.triangle_materials[t];
    auto part = std::find_if(parts.begin(), parts.end(), [&](const Part& p) { return p.material == material; });
    if (part == parts.end()) part = parts.insert(parts.end(), Part{material, {}});
    for (std::size_t k = 0; k < 3; ++k) part->indices.push_back(mesh.indices[3 * t + k]);
  }
  return parts;
}

struct Simplified {
  Indices indices;
  float error = 0.0f;
};

Simplified collapse_edges(const Mesh& mesh, const Indices& source, std::size_t target_index_count) {
  Simplified result;
  result.indices.resize(source.size());
  result.indices.resize(meshopt_simplify(result.indices.data(), source.data(), source.size(), &mesh.positions[0].x, mesh.positions.size(),
                                         sizeof(glm::vec3), target_index_count, kAnyError, 0, &result.error));
  return result;
}

Simplified cluster_vertices(const Mesh& mesh, const Indices& source, std::size_t target_index_count) {
  Simplified result;
  result.indices.resize(source.size());
  result.indices.resize(meshopt_simplifySloppy(result.indices.data(), source.data(), source.size(), &mesh.positions[0].x,
                                               mesh.positions.size(), sizeof(glm::vec3), target_index_count, kAnyError, &result.error));
  return result;
}

/// The part in about target_index_count indices; nothing vanishes: what clustering would make nothing of stays as edge collapse leaves it.
Indices simplify_part(const Mesh& mesh, const Indices& source, std::size_t target_index_count) {
  Simplified collapsed = collapse_edges(mesh, source, target_index_count);
  const bool reached = static_cast<double>(collapsed.indices.size()) <= kSlack * static_cast<double>(target_index_count);
  Simplified clustered = cluster_vertices(mesh, source, target_index_count);
  if (clustered.indices.empty()) return std::move(collapsed.indices);
  if (reached && !collapsed.indices.empty() && collapsed.error <= clustered.error) return std::move(collapsed.indices);
  return std::move(clustered.indices);
}

/// One mesh of all parts, in the order in which a GPU's vertex cache likes them.
Mesh merge(const Mesh& source, const std::vector<Part>& parts) {
  Mesh merged;
  merged.positions = source.positions;
  merged.normals = source.normals;
  merged.uvs = source.uvs;
  for (const Part& part : parts) {
    Indices ordered(part.indices.size());
    meshopt_optimizeVertexCache(ordered.data(), part.indices.data(), part.indices.size(), source.positions.size());
    merged.indices.insert(merged.indices.end(), ordered.begin(), ordered.end());
    merged.triangle_materials.resize(merged.indices.size() / 3, part.material);
  }
  return compact(merged);
}

std::size_t triangle_count(const std::vector<Part>& parts) {
  std::size_t index_count = 0;
  for (const Part& part : parts) index_count += part.indices.size();
  return index_count / 3;
}

}  // namespace

WoodLods simplify_wood(const Mesh& wood) {
  WoodLods chain;
  if (wood.indices.empty()) return chain;
  const std::vector<Part> source = split_by_material(wood);
  chain.lods.push_back(merge(wood, source));
  std::size_t divisor = kReduction;
  while (chain.lods.size() < kMaxLods && chain.lods.back().triangle_materials.size() > kLeastTriangles) {
    std::vector<Part> parts;
    for (const Part& part : source) {
      const std::size_t target_index_count = std::max<std::size_t>(part.indices.size() / 3 / divisor, 4) * 3;
      parts.push_back({part.material, simplify_part(wood, part.indices, target_index_count)});
    }
    const double share = static_cast<double>(triangle_count(parts)) / static_cast<double>(chain.lods.back().triangle_materials.size());
    if (share > kLeastProgress) break;
    chain.lods.push_back(merge(wood, parts));
    divisor *= kReduction;
  }
  return chain;
}

}  // namespace coppice::bake
