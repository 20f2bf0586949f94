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

/// A wood LoD from a WOOD chunk's bytes.
/// errors  bad_file: not the Draco mesh FORMAT.md describes, or a material >= material_count; out_of_memory
Result<WoodMesh> decode_wood(std::span<const std::uint8_t> bytes, std::uint32_t material_count);

}  // namespace coppice
