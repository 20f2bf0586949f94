#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "plant.h"

namespace coppice::bake {

/// Triangles in scene space, one material number each, and for every vertex the mesh instance it came from.
struct TriangleSoup {
  Mesh mesh;
  glm::dvec3 anchor{0.0};  ///< the place of the mesh's (0, 0, 0) in the scene: near the plant if that stands far off, else (0, 0, 0)
  std::vector<std::uint32_t> vertex_instances;
  std::vector<glm::vec4> vertex_colors;    ///< [vertices] linear, 0..1; white where a primitive has none; empty where none has any
  std::set<std::uint32_t> wind_materials;  ///< materials of coloured meshes that are named after wind (node_names.h)
};

/// Drops vertices that no triangle uses and numbers the rest in order of first use.
Mesh compact(const Mesh& mesh);

/// Turns triangles so that their corners run counter-clockwise as seen from where their normals point: the renderer lights the side that is
/// seen.
void turn_to_normals(Mesh& mesh);

}  // namespace coppice::bake
