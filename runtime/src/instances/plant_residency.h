#pragma once

#include <cstdint>

namespace coppice::gpu {

/// The parts of a plant that may be drawn in this frame.
struct PlantResidency {
  std::uint32_t leaf_count = 1;
  std::uint32_t wood_mask = 0;
  bool leaf_meshes = false;
};

}  // namespace coppice::gpu
