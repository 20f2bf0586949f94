#pragma once

#include <cstdint>
#include <span>

#include "result.h"
#include "wood_codec.h"

namespace coppice {

/// Walks a Draco edgebreaker stream up to its attributes without allocating. Checks that the triangle count is that of the shape and within
/// COPPICE_MAX_WOOD_TRIANGLES_PER_BYTE, and that the attributes are exactly position, normal, uv and material, and for leaf meshes also the
/// stalk.
/// errors  bad_file: the field, and where in the chunk
Result<void> check_wood_header(std::span<const std::uint8_t> bytes, const WoodShape& shape);

}  // namespace coppice
