#pragma once

#include <array>
#include <limits>
#include <string>

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
  void add(const PointBox& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
  [[nodiscard]] Point extent() const { return high - low; }
  [[nodiscard]] bool is_empty() const { return low.x > high.x; }
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

/// Width (x), height (y) and depth (z) of leaves and wood, metres.
std::array<double, 3> plant_size_m(const Plant& plant);

/// Writes a size as "5.31 m high, 3.1 x 3.2 m wide".
std::string size_text(const std::array<double, 3>& size_m);

/// Warns of a plant larger than 120 m or smaller than 1 cm, with the unit that its file may be in; empty for any other.
/// metres_per_unit  the unit in which the file was read
std::string size_warning(const std::array<double, 3>& size_m, double metres_per_unit);

}  // namespace coppice::bake
