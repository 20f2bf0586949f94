#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "placement.h"
#include "terrain.h"

namespace forest {

/// Where a plant's stems meet the ground: a low mound of earth with roots in it stands there.
struct Foot {
  glm::vec2 position;
  float radius_m = 0;  ///< radius of the mound
  float turn_rad = 0;
};

/// The feet of a forest in a grid of square cells, so that those near the eye are found among a million.
struct Feet {
  float half_extent_m = 0;
  std::uint32_t side = 0;            ///< cells; 0: there are none
  std::vector<std::uint32_t> first;  ///< [side^2 + 1]: of each cell in `feet`
  std::vector<Foot> feet;
};

/// None under a single plant, which is shown as it is.
Feet make_feet(const Planting& planting);

/// How near the middle of a mound a place is: 1 in it, 0 outside of all.
float foot_share(const Feet& feet, glm::vec2 at);

constexpr std::size_t kMaxMounds = 256;
constexpr std::uint32_t kMoundVertices = 64;  ///< four rings of sixteen
constexpr std::uint32_t kMoundIndices = 3 * 16 * 6;

/// Triangles of kMaxMounds mounds.
std::vector<std::uint32_t> mound_indices();
/// The mounds near the eye and in view; with distance they sink into the ground, so that none is seen to come.
/// out  [kMaxMounds * kMoundVertices]. Returns how many mounds were written.
std::size_t gather_mounds(const Terrain& terrain, const Feet& feet, const glm::mat4& clip_from_world, glm::vec3 eye,
                          std::span<TerrainVertex> out);

}  // namespace forest
