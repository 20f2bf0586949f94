#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gltf_instances.h"
#include "result.h"
#include "triangle_soup.h"

namespace coppice::bake {

/// A primitive of a mesh as an instance places it.
struct PlacedPrimitive {
  const MeshInstance& instance;
  std::uint32_t instance_index = 0;
  std::uint32_t primitive_index = 0;
  std::uint32_t material = 0;                        ///< the number for triangle_materials
  std::optional<std::uint32_t> wind_color_set = {};  ///< n: the red of COLOR_n says how flexible a vertex is, and is no colour
};

/// Appends a primitive where its instance places it: triangles, strips and fans; points have nothing to append. A mirroring
/// transform also reverses the winding, so that fronts stay fronts. Missing normals become the area-weighted mean of the triangles round a
/// vertex, missing uvs (0, 0). Wind weights come from the vertex colours that `placed` names, else from the attribute _WIND_WEIGHT, else
/// from _WIND: the first component of whatever shape, 0..1. How normals lie comes from _SPREAD, and beside it opacity from the alpha of
/// COLOR_0, as gltf_write.h writes them. What cannot be read of these is left out, with a warning.
/// errors  bad_file: a position that is not finite or beyond 1e8 m, an index beyond the vertices, attributes of unequal length
Result<void> append_primitive(const tinygltf::Model& model, const PlacedPrimitive& placed, TriangleSoup& soup,
                              std::vector<std::string>& warnings);

}  // namespace coppice::bake
