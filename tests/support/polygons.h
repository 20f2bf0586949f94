#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plant.h"

namespace coppice::test {

/// Appends a polygon as a fan of triangles, on vertices of its own, which look along +Z. uvs: one for each corner, or none for zeros
inline void add_polygon(bake::Mesh& mesh, std::span<const glm::vec3> corners, std::span<const glm::vec2> uvs = {},
                        std::uint32_t material = 0) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    mesh.positions.push_back(corners[i]);
    mesh.normals.emplace_back(0.0f, 0.0f, 1.0f);
    mesh.uvs.push_back(uvs.empty() ? glm::vec2(0.0f) : uvs[i]);
  }
  for (std::uint32_t i = 1; i + 1 < corners.size(); ++i) {
    mesh.indices.insert(mesh.indices.end(), {first, first + i, first + i + 1});
    mesh.triangle_materials.push_back(material);
  }
}

}  // namespace coppice::test
