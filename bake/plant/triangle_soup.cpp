#include "triangle_soup.h"

#include <utility>

#include <glm/geometric.hpp>

namespace coppice::bake {

Mesh compact(const Mesh& mesh) {
  Mesh compacted;
  std::vector<std::uint32_t> new_index(mesh.positions.size(), kNone);
  compacted.indices.reserve(mesh.indices.size());
  for (const std::uint32_t index : mesh.indices) {
    if (new_index[index] == kNone) {
      new_index[index] = static_cast<std::uint32_t>(compacted.positions.size());
      compacted.positions.push_back(mesh.positions[index]);
      compacted.normals.push_back(mesh.normals[index]);
      compacted.uvs.push_back(mesh.uvs[index]);
      if (!mesh.vertex_opacities.empty()) compacted.vertex_opacities.push_back(mesh.vertex_opacities[index]);
      if (!mesh.vertex_alongs.empty()) compacted.vertex_alongs.push_back(mesh.vertex_alongs[index]);
      if (!mesh.wind_weights.empty()) compacted.wind_weights.push_back(mesh.wind_weights[index]);
    }
    compacted.indices.push_back(new_index[index]);
  }
  compacted.triangle_materials = mesh.triangle_materials;
  compacted.triangle_tints = mesh.triangle_tints;
  return compacted;
}

void turn_to_normals(Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::uint32_t a = mesh.indices[i], b = mesh.indices[i + 1], c = mesh.indices[i + 2];
    const glm::vec3 face = glm::cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    if (glm::dot(face, mesh.normals[a] + mesh.normals[b] + mesh.normals[c]) < 0.0f) std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  }
}

}  // namespace coppice::bake
