#include "bounds.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace coppice::bake {

Sphere bounding_sphere(const Foliage& foliage) {
  return foliage.quads.empty() ? Sphere{} : plant_sphere(foliage, {});
}

Sphere plant_sphere(const Foliage& foliage, const Mesh& wood, const LeafMeshes& leaf_meshes) {
  const auto for_each_point = [&](const auto& visit) {
    for (const Quad& quad : foliage.quads) std::ranges::for_each(quad, visit);
    std::ranges::for_each(wood.positions, visit);
    for (const LeafMeshPart& part : leaf_meshes.parts) std::ranges::for_each(part.mesh.positions, visit);
  };
  PointBox<glm::vec3> box;
  for_each_point([&](const glm::vec3& point) { box.add(point); });
  Sphere sphere{(box.low + box.high) * 0.5f, 0.0f};
  for_each_point([&](const glm::vec3& point) { sphere.radius = std::max(sphere.radius, glm::distance(sphere.center, point)); });
  return sphere;
}

}  // namespace coppice::bake
