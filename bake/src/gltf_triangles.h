#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "gltf_scene.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// COLOR_0 over the triangles of a material, linear, weighted by area; white where a primitive has none.
struct ColorSum {
  glm::dvec4 color_area_m2{0.0};
  double area_m2 = 0.0;
  glm::vec4 smallest{1.0f}, largest{0.0f};  ///< of any vertex
};

/// Triangles in scene space, one material number each, and for every vertex the mesh instance it came from.
struct TriangleSoup {
  Mesh mesh;
  std::vector<std::uint32_t> vertex_instances;
  std::vector<ColorSum> material_colors;  ///< by material number; short where the last ones have no triangle
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

/// Multiplies materials by the mean of their vertex colours, the simplest honest place for them while a plant's vertices have none: a leaf
/// quad could not show them anyway. Warns where the mean stands for different colours, and of alpha, which is not used.
void apply_vertex_colors(const TriangleSoup& soup, std::vector<Material>& materials, std::vector<std::string>& warnings);

/// Drops vertices that no triangle uses and numbers the rest in order of first use.
Mesh compact(const Mesh& mesh);

}  // namespace coppice::bake
