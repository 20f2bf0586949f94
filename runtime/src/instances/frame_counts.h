#pragma once

#include <cstdint>

namespace coppice::gpu {

/// What a view drew in the latest frame whose counts have arrived.
struct FrameCounts {
  std::uint64_t frame = 0;  ///< 0: none yet
  std::uint32_t visible_instances = 0;
  std::uint32_t occluded_instances = 0;  ///< in view, but hidden by others
  std::uint64_t leaves = 0;
  std::uint64_t wood_triangles = 0;
  std::uint32_t leaf_mesh_instances = 0;
  std::uint64_t leaf_mesh_triangles = 0;
  std::uint64_t hardware_triangles = 0;  ///< triangles of leaves, leaf meshes and wood
};

}  // namespace coppice::gpu
