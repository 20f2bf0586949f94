#include "mesh_simplify.h"

#include <meshoptimizer.h>

namespace coppice::bake {
namespace {

std::vector<std::uint32_t> run(const Mesh& mesh, std::size_t target_index_count, MeshSimplifier simplifier) {
  constexpr float kAnyError = 1.0f;
  std::vector<std::uint32_t> indices(mesh.indices.size());
  if (simplifier == MeshSimplifier::collapse)
    indices.resize(meshopt_simplify(indices.data(), mesh.indices.data(), mesh.indices.size(), &mesh.positions[0].x, mesh.positions.size(),
                                    sizeof(glm::vec3), target_index_count, kAnyError, 0, nullptr));
  else
    indices.resize(meshopt_simplifySloppy(indices.data(), mesh.indices.data(), mesh.indices.size(), &mesh.positions[0].x,
                                          mesh.positions.size(), sizeof(glm::vec3), target_index_count, kAnyError, nullptr));
  return indices;
}

}  // namespace

Mesh simplify_mesh(const Mesh& mesh, std::uint32_t triangle_count, MeshSimplifier simplifier) {
  Mesh result;
  result.positions = mesh.positions;
  result.normals = mesh.normals;
  result.uvs = mesh.uvs;
  if (mesh.indices.empty()) return result;
  std::vector<std::uint32_t> vertex_materials(mesh.positions.size(), 0);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) vertex_materials[mesh.indices[i]] = mesh.triangle_materials[i / 3];

  const std::vector<std::uint32_t> indices = run(mesh, std::size_t{triangle_count} * 3, simplifier);
  for (std::size_t t = 0; t + 2 < indices.size(); t += 3) {
    const glm::vec3 &a = mesh.positions[indices[t]], &b = mesh.positions[indices[t + 1]], &c = mesh.positions[indices[t + 2]];
    if (a == b || b == c || c == a) continue;
    result.indices.insert(result.indices.end(), {indices[t], indices[t + 1], indices[t + 2]});
    result.triangle_materials.push_back(vertex_materials[indices[t]]);
  }
  return result;
}

}  // namespace coppice::bake
