#include "level.h"

#include <cmath>
#include <numbers>

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

}  // namespace

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
