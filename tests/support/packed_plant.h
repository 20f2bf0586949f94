#pragma once

// Plants as .coppice files in memory.

#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pack.h"
#include "random_tree.h"

namespace coppice::test {

inline std::vector<std::uint8_t> packed(const bake::BakedPlant& plant, bake::TextureCoding textures = bake::TextureCoding::bc) {
  bake::PackSizes sizes;
  Result<std::vector<std::uint8_t>> file = bake::pack(plant, sizes, textures);
  if (!file) throw std::runtime_error(file.error().message());
  return *std::move(file);
}

inline std::vector<std::uint8_t> packed_plant(const RandomPlantOptions& options, bake::TextureCoding textures = bake::TextureCoding::bc) {
  return packed(random_plant(options), textures);
}

}  // namespace coppice::test
