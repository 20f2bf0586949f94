#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "coppice/format.h"
#include "result.h"

namespace coppice {

struct WoodVertex {
  std::array<float, 3> position{};  ///< object space, metres
  std::array<float, 3> normal{};    ///< unit
  std::array<float, 2> uv{};
  std::uint32_t material = 0;
  std::array<std::uint16_t, 3> stalk{};  ///< leaf meshes: corner 0 of the leaf's quad, quantised in the leaf box; wood: 0
};

struct WoodMesh {
  std::vector<WoodVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< 3 per triangle, each < vertices.size()
};

/// What the front of the file says of a wood LoD, or of a chunk of leaf meshes.
struct WoodShape {
  std::uint32_t vertex_count = 0;    ///< coppice_file_plant::wood_vertex_counts
  std::uint32_t triangle_count = 0;  ///< coppice_file_plant::wood_triangle_counts
  std::span<const coppice_file_material> materials;
  bool has_stalks = false;  ///< leaf meshes
};

/// A wood LoD from a WOOD chunk's bytes, or leaf meshes from a LEAF_MESH chunk's, of exactly the counts in `shape`; they are compared
/// before memory is allocated. Any thread.
/// errors  bad_file: not the Draco mesh FORMAT.md describes, of other counts, a material that is not there or, of wood, that only leaf
///         meshes show, or a stalk outside the leaf box; out_of_memory
Result<WoodMesh> decode_wood(std::span<const std::uint8_t> bytes, const WoodShape& shape);

}  // namespace coppice
