#pragma once

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// A WOOD or LEAF_MESH chunk and the size of the decoded mesh.
struct EncodedWood {
  std::vector<std::uint8_t> bytes;  ///< empty when no triangle is left
  std::uint32_t vertex_count = 0;
  std::uint32_t triangle_count = 0;
};

/// Encodes a wood LoD: positions 14 bits, normals 10, uvs 12, in the mesh's box. Triangles of two equal corners are dropped; vertices are
/// doubled where materials meet. Same mesh, same bytes.
/// errors  invalid_argument: an index or material out of range, a number that is not finite; internal: Draco failed
Result<EncodedWood> encode_wood(const Mesh& mesh, std::uint32_t material_count);

/// Encodes leaf meshes like wood, with positions of `position_bits` (over the longest side of the mesh's box), uvs to 1/4096 of the image
/// if they span no more than 256 of them, and the stalk of each vertex's leaf, exactly.
/// stalks  [mesh.positions.size()]
/// errors  as encode_wood
Result<EncodedWood> encode_leaf_mesh(const Mesh& mesh, std::span<const QuantisedPoint> stalks, std::uint32_t material_count,
                                     int position_bits);

}  // namespace coppice::bake
