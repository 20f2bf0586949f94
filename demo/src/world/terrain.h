#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace forest {

struct TerrainVertex {
  glm::vec3 position;
  glm::vec3 normal;
  float foot = 0;  ///< 1 where a stem comes out of the ground, 0 away from stems
};

struct TerrainChunk {
  std::uint32_t first_index = 0;
  std::uint32_t index_count = 0;
  glm::vec3 box_min;
  glm::vec3 box_max;
};

/// Gently rolling ground round the origin: a grid whose cells are about 2 m in the forest and grow towards the horizon.
struct Terrain {
  std::vector<float> axis;              ///< grid coordinates, ascending, the same for x and z, metres
  std::vector<TerrainVertex> vertices;  ///< [axis.size()^2], rows of constant z
  std::vector<std::uint32_t> indices;
  std::vector<TerrainChunk> chunks;
};

/// half_extent_m  half the side of the planted square
Terrain make_terrain(float half_extent_m, std::uint32_t seed);
/// The same, level at this height.
Terrain make_flat_terrain(float half_extent_m, float height_m);
/// Height of the drawn triangles, so that what stands on the ground touches it. Points outside are clamped to the edge.
float height_at(const Terrain& terrain, float x, float z);

/// The six clip planes' inward half-spaces tested against a box. Conservative: false only when the box is surely outside.
bool box_in_view(const glm::mat4& clip_from_world, const glm::vec3& box_min, const glm::vec3& box_max);

}  // namespace forest
