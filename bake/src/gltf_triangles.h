#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "gltf_scene.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Triangles in scene space, one material number each, and for every vertex the mesh instance it came from.
struct TriangleSoup {
  Mesh mesh;
  std::vector<std::uint32_t> vertex_instances;
  std::vector<glm::vec4> vertex_colors;    ///< [vertices] linear, 0..1; white where a primitive has none; empty where none has any
  std::set<std::uint32_t> wind_materials;  ///< of coloured meshes that are called after wind (vertex_colors.h)
};

/// Whether the document asks for more triangles or vertices than a plant may have; nothing is read or allocated.
/// instance_counts  [meshes] of mesh_instance_counts
/// errors  unsupported: names the primitive that is too much
Result<void> check_totals(const tinygltf::Model& model, std::span<const std::uint64_t> instance_counts);

/// Appends one primitive of a mesh as `instance` number `instance_index` places it: triangles, strips and fans; points and lines have
/// nothing to append. A transform that mirrors turns the winding round, so that fronts stay fronts. Missing normals are the area-weighted
/// mean of the triangles round a vertex, missing uvs (0, 0).
/// material  what to write in triangle_materials
/// errors  bad_file: a position that is not finite or beyond 1e8 m, an index beyond the vertices, attributes of unequal length;
///         unsupported: more triangles than a plant may have
Result<void> append_primitive(const tinygltf::Model& model, const MeshInstance& instance, std::uint32_t instance_index,
                              std::uint32_t primitive_index, std::uint32_t material, TriangleSoup& soup,
                              std::vector<std::string>& warnings);

/// Drops vertices that no triangle uses and numbers the rest in order of first use.
Mesh compact(const Mesh& mesh);

/// Turns triangles so that their corners run counter-clockwise as seen from where their normals point: lights are those of the side seen.
void turn_to_normals(Mesh& mesh);

}  // namespace coppice::bake
