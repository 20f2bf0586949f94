#pragma once

#include "plant.h"
#include "result.h"

namespace coppice {
struct PlantFile;
}

namespace coppice::bake {

/// The inverse of pack(), for tools and tests: positions are quantised, images are the largest level of their textures. Checks every
/// invariant of FORMAT.md on the way.
/// errors  bad_file, naming the field and the byte offset
Result<BakedPlant> unpack(std::span<const std::uint8_t> file);

/// array  what a file's front holds
template <class Array>
[[nodiscard]] auto to_vector(const Array& array) {
  return std::vector(array.begin(), array.end());
}

/// Unpacks one wood LoD alone. plant  from read_front; it has this LoD. errors  bad_file
Result<Mesh> unpack_wood(const PlantFile& plant, std::span<const std::uint8_t> file, std::uint32_t lod);

}  // namespace coppice::bake
