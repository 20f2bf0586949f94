#pragma once

// glTF files of several nodes made of simple shapes: packs of plants, and plants of many parts.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "gltf_builder.h"

namespace coppice::test {

/// Triangles of one primitive.
struct Shape {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  void add_quad(const std::array<glm::vec3, 4>& corners);
};

/// A square post of `rings` pieces.
Shape post(float height, float width, glm::vec3 foot = {}, glm::vec3 lean = {}, int rings = 4);
/// Small quads in an ellipsoid.
Shape leaves(int count, glm::vec3 centre, glm::vec3 radii, float size, std::uint64_t seed);
/// Upright quads through one axis.
Shape crossed_quads(float height, float width, int count = 2);
/// A flat square, a little below 0.
Shape plate(float width);

using Parts = std::vector<std::pair<std::string, Shape>>;  ///< by material

/// Trunk and crown of a tree `height` high.
Parts trunk_part(float height, std::uint64_t seed = 0);
Parts crown_part(int count, float height, std::uint64_t seed);
Parts tree(int count, float height, std::uint64_t seed);

/// A file under construction: nodes with parents, meshes of several materials. Materials with "eaf" or "eaves" in their names, and "card",
/// are masked.
struct Pack {
  GltfBuilder file;
  std::map<std::string, int> materials;

  int material(const std::string& name);
  int mesh(const Parts& parts, const std::string& name = {});
  int node(const std::string& name, int mesh_index, glm::vec3 at = {}, int parent = -1);
  /// A node with a mesh of its own.
  int part(const std::string& name, const Parts& parts, glm::vec3 at = {}, int parent = -1) { return node(name, mesh(parts), at, parent); }
};

}  // namespace coppice::test
