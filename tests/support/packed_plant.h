#pragma once

// Plants as .coppice files in memory.

#include <cstdint>
#include <vector>

#include "pack.h"
#include "random_tree.h"
#include "results.h"

namespace coppice::test {

inline std::vector<std::uint8_t> packed(const bake::BakedPlant& plant, bake::TextureCoding textures = bake::TextureCoding::bc) {
  bake::PackSizes sizes;
  return must(bake::pack(plant, sizes, textures));
}

inline std::vector<std::uint8_t> packed_plant(const RandomPlantOptions& options, bake::TextureCoding textures = bake::TextureCoding::bc) {
  return packed(random_plant(options), textures);
}

}  // namespace coppice::test
