#pragma once

#include <cstdint>
#include <span>

#include "result.h"
#include "wood_codec.h"

namespace coppice {

/// Walks a Draco edgebreaker stream up to its attributes without allocating: the triangle count is the shape's, no more than
/// COPPICE_MAX_WOOD_TRIANGLES_PER_BYTE allows, and the attributes are exactly position, normal, uv and material, of leaf meshes also
/// the stalk.
/// errors  bad_file: the field, and where in the chunk
Result<void> check_wood_header(std::span<const std::uint8_t> bytes, const WoodShape& shape);

}  // namespace coppice
