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
  std::array<std::uint16_t, 3> stalk{};  ///< for leaf meshes: corner 0 of the leaf's quad, quantised in the leaf box; 0 for wood
};

/// A mesh that is stored elsewhere.
struct WoodSpan {
  std::span<const WoodVertex> vertices;
  std::span<const std::uint32_t> indices;  ///< 3 per triangle, each < vertices.size()
};

struct WoodMesh {
  HookArray<WoodVertex> vertices;
  HookArray<std::uint32_t> indices;

  operator WoodSpan() const { return {vertices, indices}; }
};

/// Sizes of a wood LoD, or of a chunk of leaf meshes, that the front of the file states.
struct WoodShape {
  std::uint32_t vertex_count = 0;    ///< coppice_file_plant::wood_vertex_counts
  std::uint32_t triangle_count = 0;  ///< coppice_file_plant::wood_triangle_counts
  std::span<const coppice_file_material> materials;
  bool has_stalks = false;  ///< true for leaf meshes
};

/// Decodes a wood LoD from a WOOD chunk's bytes, or leaf meshes from a LEAF_MESH chunk's. The counts must equal `shape`; they are compared
/// before memory is allocated. Draco allocates its temporary output itself. Any thread.
/// errors  bad_file: not the Draco mesh that FORMAT.md describes, other counts, an unknown material, wood with a material of leaf meshes
///         only, or a stalk outside the leaf box; out_of_memory
Result<WoodMesh> decode_wood(std::span<const std::uint8_t> bytes, const WoodShape& shape,
                             const coppice_allocator& allocator = default_allocator());

}  // namespace coppice
