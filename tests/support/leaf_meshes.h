#pragma once

// Plants whose leaves are meshes written out by hand.

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::test {

struct LeafMesh {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  std::vector<glm::vec2> uvs = {};
};

/// Stalk at the origin, tip at (2, 0, 0), widest at x = 1: 0.5 to +y, 0.3 to -y, an area of 0.8. The vertex on its midrib makes it no quad.
inline LeafMesh kite() {
  return {{{0.0f, 0.0f, 0.0f}, {1.0f, -0.3f, 0.0f}, {2.0f, 0.0f, 0.0f}, {1.0f, 0.5f, 0.0f}, {1.0f, 0.0f, 0.0f}},
          {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4}};
}

/// A plant of these leaves, all of material 0, and a short upright twig of wood at `wood`, of material 1. Both materials are the default.
inline bake::Plant plant_of_meshes(const std::vector<LeafMesh>& leaves, const glm::vec3& wood = {-1.0f, 0.0f, 0.0f}) {
  bake::Plant plant;
  plant.materials.resize(2);
  bake::Mesh& mesh = plant.foliage;
  for (const LeafMesh& leaf : leaves) {
    const auto first_vertex = static_cast<std::uint32_t>(mesh.positions.size());
    plant.leaves.push_back(
        {static_cast<std::uint32_t>(mesh.triangle_materials.size()), static_cast<std::uint32_t>(leaf.indices.size() / 3)});
    mesh.positions.insert(mesh.positions.end(), leaf.positions.begin(), leaf.positions.end());
    mesh.normals.resize(mesh.positions.size(), {0.0f, 0.0f, 1.0f});
    mesh.uvs.insert(mesh.uvs.end(), leaf.uvs.begin(), leaf.uvs.end());
    mesh.uvs.resize(mesh.positions.size(), {0.0f, 0.0f});
    for (const std::uint32_t index : leaf.indices) mesh.indices.push_back(first_vertex + index);
    mesh.triangle_materials.resize(mesh.indices.size() / 3, 0);
  }
  plant.wood.positions = {wood, wood + glm::vec3(0.0f, 0.01f, 0.0f), wood + glm::vec3(0.0f, 0.0f, 0.01f)};
  plant.wood.normals.assign(3, {1.0f, 0.0f, 0.0f});
  plant.wood.uvs.assign(3, {0.0f, 0.0f});
  plant.wood.indices = {0, 1, 2};
  plant.wood.triangle_materials = {1};
  return plant;
}

}  // namespace coppice::test
