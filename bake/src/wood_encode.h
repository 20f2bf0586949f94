#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// A WOOD chunk and what it decodes to.
struct EncodedWood {
  std::vector<std::uint8_t> bytes;  ///< empty when no triangle is left
  std::uint32_t vertex_count = 0;
  std::uint32_t triangle_count = 0;
};

/// Codes a wood LoD: positions 14 bits, normals 10, uvs 12, in the box of the mesh. Triangles of two equal corners are dropped; vertices
/// are doubled where materials meet. Same mesh, same bytes. errors  invalid_argument: an index or material out of range, a number that is
/// not finite; internal: Draco failed
Result<EncodedWood> encode_wood(const Mesh& mesh, std::uint32_t material_count);

}  // namespace coppice::bake
