#include "terrain.h"

#include <algorithm>
#include <cmath>

#include "noise.h"

namespace forest {
namespace {

constexpr std::uint32_t kCells = 128;
constexpr std::uint32_t kChunkCells = 16;
constexpr float kGroundReach_m = 1500;

float height_m(float x, float z, float half_extent_m, std::uint32_t seed) {
  const float rolling = 3.2f * fractal_noise(x / 62, z / 62, 2, seed);
  const float bumps = 0.28f * gradient_noise(x / 9, z / 9, seed + 17);
  const float radius = std::hypot(x, z) / half_extent_m;
  const float rise = std::clamp((radius - 1.3f) / 5, 0.0f, 1.0f);
  const float hills = rise * (3 + 4 * gradient_noise(x / 210, z / 210, seed + 31));
  return rolling + bumps + hills;
}

// An odd polynomial: nearly linear over the planted square, steep outside it.
std::vector<float> make_axis(float half_extent_m) {
  const float inner = 1.7f * half_extent_m;
  const float outer = std::max(kGroundReach_m - inner, 0.0f);
  std::vector<float> axis;
  for (std::uint32_t i = 0; i <= kCells; ++i) {
    const float u = 2 * static_cast<float>(i) / kCells - 1;
    axis.push_back(inner * u + outer * std::pow(u, 9.0f));
  }
  return axis;
}

// Diagonals run from (x0, z0) to (x1, z1) in every cell; height_at relies on it.
TerrainChunk append_chunk(Terrain& terrain, std::uint32_t cell_x, std::uint32_t cell_z) {
  const std::uint32_t stride = kCells + 1;
  TerrainChunk chunk;
  chunk.first_index = static_cast<std::uint32_t>(terrain.indices.size());
  chunk.box_min = chunk.box_max = terrain.vertices[cell_z * stride + cell_x].position;
  for (std::uint32_t z = cell_z; z <= cell_z + kChunkCells; ++z)
    for (std::uint32_t x = cell_x; x <= cell_x + kChunkCells; ++x) {
      const std::uint32_t a = z * stride + x;
      chunk.box_min = glm::min(chunk.box_min, terrain.vertices[a].position);
      chunk.box_max = glm::max(chunk.box_max, terrain.vertices[a].position);
      if (z == cell_z + kChunkCells || x == cell_x + kChunkCells) continue;
      const std::uint32_t cell[] = {a, a + stride, a + stride + 1, a, a + stride + 1, a + 1};
      terrain.indices.insert(terrain.indices.end(), std::begin(cell), std::end(cell));
    }
  chunk.index_count = static_cast<std::uint32_t>(terrain.indices.size()) - chunk.first_index;
  return chunk;
}

// Index of the cell that holds `value`, and where in it.
std::pair<std::size_t, float> locate(const std::vector<float>& axis, float value) {
  const auto above = std::upper_bound(axis.begin() + 1, axis.end() - 1, value);
  const auto cell = static_cast<std::size_t>(above - axis.begin()) - 1;
  return {cell, std::clamp((value - axis[cell]) / (axis[cell + 1] - axis[cell]), 0.0f, 1.0f)};
}

}  // namespace

namespace {

/// height(x, z) in metres.
template <class Height>
Terrain make_grid(float half_extent_m, const Height& height) {
  Terrain terrain;
  terrain.axis = make_axis(half_extent_m);
  for (float z : terrain.axis)
    for (float x : terrain.axis) {
      constexpr float kStep_m = 0.5f;
      const glm::vec3 normal(height(x - kStep_m, z) - height(x + kStep_m, z), 2 * kStep_m, height(x, z - kStep_m) - height(x, z + kStep_m));
      terrain.vertices.push_back({{x, height(x, z), z}, glm::normalize(normal), 0});
    }
  for (std::uint32_t z = 0; z < kCells; z += kChunkCells)
    for (std::uint32_t x = 0; x < kCells; x += kChunkCells) terrain.chunks.push_back(append_chunk(terrain, x, z));
  return terrain;
}

}  // namespace

Terrain make_terrain(float half_extent_m, std::uint32_t seed) {
  return make_grid(half_extent_m, [&](float x, float z) { return height_m(x, z, half_extent_m, seed); });
}

Terrain make_flat_terrain(float half_extent_m, float height_m) {
  return make_grid(half_extent_m, [&](float, float) { return height_m; });
}

float height_at(const Terrain& terrain, float x, float z) {
  const auto [cell_x, u] = locate(terrain.axis, x);
  const auto [cell_z, v] = locate(terrain.axis, z);
  const auto y = [&, i = cell_x, k = cell_z](std::size_t dx, std::size_t dz) {
    return terrain.vertices[(k + dz) * terrain.axis.size() + i + dx].position.y;
  };
  if (v > u) return y(0, 0) + v * (y(0, 1) - y(0, 0)) + u * (y(1, 1) - y(0, 1));
  return y(0, 0) + u * (y(1, 0) - y(0, 0)) + v * (y(1, 1) - y(1, 0));
}

bool box_in_view(const glm::mat4& clip_from_world, const glm::vec3& box_min, const glm::vec3& box_max) {
  const glm::mat4 rows = glm::transpose(clip_from_world);
  const glm::vec4 planes[] = {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1], rows[3] - rows[1], rows[2], rows[3] - rows[2]};
  for (const glm::vec4& plane : planes) {
    const glm::vec3 farthest(plane.x > 0 ? box_max.x : box_min.x, plane.y > 0 ? box_max.y : box_min.y, plane.z > 0 ? box_max.z : box_min.z);
    if (glm::dot(glm::vec3(plane), farthest) + plane.w < 0) return false;
  }
  return true;
}

}  // namespace forest
