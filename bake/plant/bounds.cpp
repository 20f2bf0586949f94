#include "bounds.h"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace coppice::bake {

Sphere plant_sphere(const Foliage& foliage, const Mesh& wood, const LeafMeshes& leaf_meshes) {
  glm::vec3 low = foliage.quads.front()[0], high = low;
  const auto include = [&](const glm::vec3& point) { low = glm::min(low, point), high = glm::max(high, point); };
  for (const Quad& quad : foliage.quads) std::ranges::for_each(quad, include);
  std::ranges::for_each(wood.positions, include);
  for (const LeafMeshPart& part : leaf_meshes.parts) std::ranges::for_each(part.mesh.positions, include);
  Sphere sphere{(low + high) * 0.5f, 0.0f};
  const auto reach = [&](const glm::vec3& point) { sphere.radius = std::max(sphere.radius, glm::length(point - sphere.center)); };
  for (const Quad& quad : foliage.quads) std::ranges::for_each(quad, reach);
  std::ranges::for_each(wood.positions, reach);
  for (const LeafMeshPart& part : leaf_meshes.parts) std::ranges::for_each(part.mesh.positions, reach);
  return sphere;
}

Sphere bounding_sphere(const Foliage& foliage) {
  return foliage.quads.empty() ? Sphere{} : plant_sphere(foliage, {});
}

}  // namespace coppice::bake
