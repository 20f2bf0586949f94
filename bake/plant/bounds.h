#pragma once

#include <limits>

#include <glm/common.hpp>

#include "plant.h"

namespace coppice::bake {

/// The box round some points; before the first, `low` is above `high`.
template <class Point>
struct PointBox {
  using Real = typename Point::value_type;
  Point low{std::numeric_limits<Real>::max()}, high{std::numeric_limits<Real>::lowest()};

  void add(const Point& point) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  [[nodiscard]] Point extent() const { return high - low; }
};

template <class Points>
[[nodiscard]] auto box_of(const Points& points) {
  PointBox<typename Points::value_type> box;
  for (const auto& point : points) box.add(point);
  return box;
}

/// Bounding sphere of leaf quads, about the centre of their box. Its radius is 0 if all vertices are one point, or if there are none.
Sphere bounding_sphere(const Foliage& foliage);

/// Bounding sphere of a plant, about the centre of the box of leaf quads, wood and leaf meshes.
Sphere plant_sphere(const Foliage& foliage, const Mesh& wood, const LeafMeshes& leaf_meshes = {});

}  // namespace coppice::bake
