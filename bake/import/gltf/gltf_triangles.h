#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gltf_instances.h"
#include "result.h"
#include "triangle_soup.h"

namespace coppice::bake {

/// Whether the document asks for more triangles or vertices than a plant may have; nothing is read or allocated.
/// instance_counts  [meshes] of mesh_instance_counts
/// errors  unsupported: names the primitive that is too much
Result<void> check_totals(const tinygltf::Model& model, std::span<const std::uint64_t> instance_counts);

/// A primitive of a mesh as an instance places it.
struct PlacedPrimitive {
  const MeshInstance& instance;
  std::uint32_t instance_index = 0;
  std::uint32_t primitive_index = 0;
  std::uint32_t material = 0;                        ///< what to write in triangle_materials
  std::optional<std::uint32_t> wind_color_set = {};  ///< n: the red of COLOR_n says how flexible a vertex is, and no colour
};

/// Appends a primitive where its instance places it: triangles, strips and fans; points and lines have
/// nothing to append. A transform that mirrors turns the winding round, so that fronts stay fronts. Missing normals are the area-weighted
/// mean of the triangles round a vertex, missing uvs (0, 0). Wind weights are the vertex colours that `placed` names, else the attribute
/// _WIND_WEIGHT, else _WIND, of any shape, of which the first component counts, 0..1; one that cannot be read is left out, with a warning.
/// errors  bad_file: a position that is not finite or beyond 1e8 m, an index beyond the vertices, attributes of unequal length;
///         unsupported: more triangles than a plant may have
Result<void> append_primitive(const tinygltf::Model& model, const PlacedPrimitive& placed, TriangleSoup& soup,
                              std::vector<std::string>& warnings);

}  // namespace coppice::bake
