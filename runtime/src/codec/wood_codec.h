#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "result.h"

namespace coppice {

struct WoodVertex {
  std::array<float, 3> position{};  ///< object space, metres
  std::array<float, 3> normal{};    ///< unit
  std::array<float, 2> uv{};
  std::uint32_t material = 0;
};

struct WoodMesh {
  std::vector<WoodVertex> vertices;
  std::vector<std::uint32_t> indices;  ///< 3 per triangle, each < vertices.size()
};

/// What the front of the file says of a wood LoD.
struct WoodShape {
  std::uint32_t vertex_count = 0;    ///< coppice_file_plant::wood_vertex_counts
  std::uint32_t triangle_count = 0;  ///< coppice_file_plant::wood_triangle_counts
  std::uint32_t material_count = 0;
};

/// A wood LoD from a WOOD chunk's bytes, of exactly the counts in `shape`; they are compared before memory is allocated. Any thread.
/// errors  bad_file: not the Draco mesh FORMAT.md describes, of other counts, or a material >= material_count; out_of_memory
Result<WoodMesh> decode_wood(std::span<const std::uint8_t> bytes, const WoodShape& shape);

}  // namespace coppice
