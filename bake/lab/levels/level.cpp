#include "level.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "surface_distance.h"

namespace coppice::bake {
namespace {

void add_square(Mesh& mesh, const std::array<glm::vec3, 4>& corners, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), corners.begin(), corners.end());
  mesh.uvs.resize(mesh.positions.size(), glm::vec2(0.0f));
  mesh.normals.resize(mesh.positions.size(), glm::vec3(0.0f, 1.0f, 0.0f));
  mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
  mesh.triangle_materials.insert(mesh.triangle_materials.end(), 2, material);
}

void add_ribbon(Mesh& mesh, const Needle& needle) {
  const glm::vec3 along = needle.to - needle.from;
  const glm::vec3 other = std::abs(along.x) < std::abs(along.y) ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 across = glm::cross(along, other);
  const float length = glm::length(across);
  if (!(length > 0.0f)) return;
  const glm::vec3 half = across * (0.5f * needle.width_m / length);
  add_square(mesh, {needle.from - half, needle.to - half, needle.to + half, needle.from + half}, needle.material);
}

void add_middles(Mesh& mesh, const Voxel& voxel) {
  for (int axis = 0; axis < 3; ++axis) {
    glm::vec3 u(0.0f), v(0.0f);
    u[(axis + 1) % 3] = voxel.half_m;
    v[(axis + 2) % 3] = voxel.half_m;
    add_square(mesh, {voxel.center - u - v, voxel.center + u - v, voxel.center + u + v, voxel.center - u + v}, voxel.material);
  }
}

ShadingNormals shading(const glm::vec3& axis, float along, bool is_sided) {
  return {{axis.x, axis.y, axis.z}, along, is_sided};
}

}  // namespace

Level level_of(Mesh mesh) {
  Level level{std::move(mesh)};
  if (level.mesh.vertex_alongs.empty()) return level;
  for (std::size_t i = 0; i < level.mesh.indices.size(); i += 3) {
    const std::uint32_t corner = level.mesh.indices[i];
    const float along = level.mesh.vertex_alongs[corner];
    level.normals.push_back(shading(level.mesh.normals[corner], std::abs(along), std::signbit(along)));
  }
  return level;
}

Level modelled_level(Mesh mesh, std::span<const Material> materials) {
  Level level{std::move(mesh)};
  const auto is_sided = [&](std::uint32_t material) { return materials[material].sided_normals; };
  if (std::ranges::none_of(level.mesh.triangle_materials, is_sided)) return level;
  for (std::size_t triangle = 0; triangle < level.mesh.triangle_materials.size(); ++triangle) {
    const auto& [a, b, c] = at_corners(level.mesh.normals, level.mesh.indices, 3 * triangle);
    const glm::vec3 sum = a + b + c;
    const float length = glm::length(sum);
    const bool is_lit_by_it = is_sided(level.mesh.triangle_materials[triangle]) && length > 0.0f;
    level.normals.push_back(is_lit_by_it ? shading(sum / length, 1.0f, true) : flat_normals(face_normal(level.mesh, triangle)));
  }
  return level;
}

glm::dvec3 face_normal(const Mesh& mesh, std::size_t triangle) {
  const auto [a, b, c] = at_corners(mesh.positions, mesh.indices, 3 * triangle);
  const glm::dvec3 across = glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
  const double length = glm::length(across);
  return length > 0.0 ? across / length : glm::dvec3(0.0);
}

ShadingNormals flat_normals(const glm::dvec3& normal) {
  return shading(glm::vec3(normal), 1.0f, false);
}

const std::array<glm::dvec3, kVoxelNormalCount>& voxel_normals() {
  constexpr double kDiagonal = 1.0 / std::numbers::sqrt2;
  static const std::array<glm::dvec3, kVoxelNormalCount> normals{glm::dvec3(1, 0, 0),
                                                                 {0, 1, 0},
                                                                 {0, 0, 1},
                                                                 {kDiagonal, kDiagonal, 0},
                                                                 {kDiagonal, -kDiagonal, 0},
                                                                 glm::dvec3(kDiagonal, 0, kDiagonal),
                                                                 {kDiagonal, 0, -kDiagonal},
                                                                 {0, kDiagonal, kDiagonal},
                                                                 {0, kDiagonal, -kDiagonal}};
  return normals;
}

Mesh level_surface(const Level& level) {
  Mesh surface = level.mesh;
  for (const Needle& needle : level.needles) add_ribbon(surface, needle);
  for (const Voxel& voxel : level.voxels) add_middles(surface, voxel);
  return surface;
}

double level_area_m2(const Level& level) {
  double area_m2 = surface_area_m2(level.mesh);
  for (const Needle& needle : level.needles) area_m2 += double{glm::distance(needle.from, needle.to)} * double{needle.width_m};
  for (const Voxel& voxel : level.voxels)
    for (const float area : voxel.area_m2) area_m2 += double{area};
  return area_m2;
}

}  // namespace coppice::bake
