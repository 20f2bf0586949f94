#pragma once

#include "plant.h"
#include "result.h"
#include "texture_encode.h"

namespace coppice::bake {

/// Bytes that pack() wrote, by kind of chunk.
struct PackSizes {
  std::uint64_t file_bytes = 0;
  std::uint64_t foliage_bytes = 0;    ///< all pages
  std::uint64_t leaf_mesh_bytes = 0;  ///< without the textures that only they show
};

/// Serialises a baked plant as a .coppice file (format.h, FORMAT.md). A pure function: same plant and coding, same bytes.
/// errors  invalid_argument: a count over its format limit
Result<std::vector<std::uint8_t>> pack(const BakedPlant& plant, PackSizes& sizes, TextureCoding textures = TextureCoding::bc);

}  // namespace coppice::bake
