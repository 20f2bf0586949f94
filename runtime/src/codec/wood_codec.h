#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "hooks.h"

namespace coppice {

struct WoodVertex {
  std::array<float, 3> position{};  ///< object space, metres
  std::array<float, 3> normal{};    ///< unit
  std::array<float, 2> uv{};
  std::uint32_t material = 0;
  std::array<std::uint16_t, 3> stalk{};  ///< leaf meshes: corner 0 of the leaf's quad, quantised in the leaf box; wood: 0
};

/// A mesh that somebody else holds.
struct WoodSpan {
  std::span<const WoodVertex> vertices;
  std::span<const std::uint32_t> indices;  ///< 3 per triangle, each < vertices.size()
};

struct WoodMesh {
  HookArray<WoodVertex> vertices;
  HookArray<std::uint32_t> indices;

  operator WoodSpan() const { return {vertices, indices}; }
};

/// What the front of the file says of a wood LoD, or of a chunk of leaf meshes.
struct WoodShape {
  std::uint32_t vertex_count = 0;    ///< coppice_file_plant::wood_vertex_counts
  std::uint32_t triangle_count = 0;  ///< coppice_file_plant::wood_triangle_counts
  std::span<const coppice_file_material> materials;
  bool has_stalks = false;  ///< leaf meshes
};

/// A wood LoD from a WOOD chunk's bytes, or leaf meshes from a LEAF_MESH chunk's, of exactly the counts in `shape`; they are compared
/// before memory is allocated. What Draco decodes into for a while is of its own allocation. Any thread.
/// errors  bad_file: not the Draco mesh FORMAT.md describes, of other counts, a material that is not there or, of wood, that only leaf
///         meshes show, or a stalk outside the leaf box; out_of_memory
Result<WoodMesh> decode_wood(std::span<const std::uint8_t> bytes, const WoodShape& shape,
                             const coppice_allocator& allocator = default_allocator());

}  // namespace coppice
