#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "plant.h"
#include "result.h"
#include "texture_encode.h"

namespace coppice {
struct PlantFile;
}

namespace coppice::bake {

/// What pack() wrote, by kind of chunk.
struct PackSizes {
  std::uint64_t file_bytes = 0;
  std::uint64_t foliage_bytes = 0;  ///< all pages
  std::uint64_t wood_bytes = 0;
  std::uint64_t texture_bytes = 0;
  std::uint64_t leaf_mesh_bytes = 0;  ///< without the textures that only they show
};

/// Serialises a baked plant as a .coppice file (format.h, FORMAT.md). A pure function: same plant and coding, same bytes.
/// errors  invalid_argument: a count over its format limit
Result<std::vector<std::uint8_t>> pack(const BakedPlant& plant, PackSizes& sizes, TextureCoding textures = TextureCoding::bc);

/// The reverse, for tools and tests: positions come back quantised, images as their textures' largest level shows them. Checks every
/// invariant of FORMAT.md on the way. errors  bad_file, naming the field and the byte offset
Result<BakedPlant> unpack(std::span<const std::uint8_t> file);

/// One wood LoD of it alone. plant  of read_front; it has this LoD. errors  bad_file
Result<Mesh> unpack_wood(const PlantFile& plant, std::span<const std::uint8_t> file, std::uint32_t lod);

}  // namespace coppice::bake
