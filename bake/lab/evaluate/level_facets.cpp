#include "level_facets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

namespace coppice::bake {
namespace {

constexpr std::uint32_t kRollSteps = 8;

void normalise(std::vector<UnlitImage::Facet>& facets, double sum) {
  for (UnlitImage::Facet& facet : facets) facet.share /= sum;
}

}  // namespace

NeedleRibbon ribbon_towards(const Needle& needle, const glm::dvec3& camera) {
  NeedleRibbon ribbon;
  const glm::dvec3 from(needle.from), to(needle.to), middle = 0.5 * (from + to);
  const glm::dvec3 sideways = glm::cross(to - from, camera - middle);
  const double length = glm::length(sideways);
  if (!(length > 0.0) || !(needle.width_m > 0.0f)) return ribbon;
  const glm::dvec3 across = sideways / length, front = glm::normalize(glm::cross(across, to - from));
  const glm::vec3 half(across * (0.5 * double{needle.width_m}));
  ribbon.mesh.positions = {needle.from - half, needle.to - half, needle.to + half, needle.from + half};
  ribbon.mesh.uvs.assign(4, glm::vec2(0.0f));
  ribbon.mesh.indices = {0, 1, 2, 0, 2, 3};
  ribbon.mesh.triangle_materials = {needle.material, needle.material};
  double sum = 0.0;
  for (std::uint32_t step = 0; step < kRollSteps; ++step) {
    const double roll = std::numbers::pi * ((step + 0.5) / kRollSteps - 0.5);
    ribbon.facets.push_back({std::cos(roll) * front + std::sin(roll) * across, std::cos(roll)});
    sum += std::cos(roll);
  }
  normalise(ribbon.facets, sum);
  return ribbon;
}

VoxelFacets facets_towards(const Voxel& voxel, const glm::dvec3& camera) {
  VoxelFacets seen;
  const glm::dvec3 towards = glm::normalize(camera - glm::dvec3(voxel.center));
  for (std::size_t i = 0; i < kVoxelNormalCount; ++i) {
    const glm::dvec3& normal = voxel_normals()[i];
    const double cosine = glm::dot(normal, towards), area_m2 = double{voxel.area_m2[i]} * std::abs(cosine);
    if (!(area_m2 > 0.0)) continue;
    seen.area_m2 += area_m2;
    seen.facets.push_back({cosine < 0.0 ? -normal : normal, area_m2});
  }
  if (seen.area_m2 > 0.0) normalise(seen.facets, seen.area_m2);
  return seen;
}

BoxHit hit_box(const glm::dvec3& from, const glm::dvec3& ray, const glm::dvec3& center, double half_m) {
  BoxHit hit{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 3; ++axis) {
    const double to_middle = center[axis] - from[axis];
    if (ray[axis] == 0.0) {
      if (std::abs(to_middle) >= half_m) return {0.0, 0.0};
      continue;
    }
    const double a = (to_middle - half_m) / ray[axis], b = (to_middle + half_m) / ray[axis];
    hit.near = std::max(hit.near, std::min(a, b));
    hit.far = std::min(hit.far, std::max(a, b));
  }
  return hit;
}

}  // namespace coppice::bake
