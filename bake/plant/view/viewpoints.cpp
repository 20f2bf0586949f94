#include "viewpoints.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace coppice::bake {
namespace {

/// The eight corners of a cube and twelve points on its three golden rectangles, in a fixed order.
std::vector<glm::vec3> dodecahedron_vertices() {
  const double phi = std::numbers::phi;
  const double scale = 1.0 / std::numbers::sqrt3;
  std::vector<glm::vec3> vertices;
  const auto add = [&](double x, double y, double z) { vertices.emplace_back(x * scale, y * scale, z * scale); };
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      for (const double z : {-1.0, 1.0}) add(x, y, z);
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-1.0, 1.0}) {
      add(0.0, a / phi, b * phi);
      add(a / phi, b * phi, 0.0);
      add(b * phi, 0.0, a / phi);
    }
  }
  return vertices;
}

/// Equal steps of height and the golden angle round the Y axis: nearly even for any count.
std::vector<glm::vec3> fibonacci_sphere(std::uint32_t count) {
  const double golden_angle = 2.0 * std::numbers::pi * (1.0 - 1.0 / std::numbers::phi);
  std::vector<glm::vec3> directions;
  directions.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double y = 1.0 - (2.0 * i + 1.0) / count;
    const double ring_radius = std::sqrt(1.0 - y * y);
    const double angle = golden_angle * i;
    directions.emplace_back(ring_radius * std::cos(angle), y, ring_radius * std::sin(angle));
  }
  return directions;
}

}  // namespace

Viewpoint viewpoint_towards(const glm::vec3& direction) {
  const bool polar = std::abs(direction.y) > 0.99996f;
  const glm::vec3 reference = polar ? glm::vec3(0.0f, 0.0f, 1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
  Viewpoint view;
  view.direction = direction;
  view.right = glm::normalize(glm::cross(reference, direction));
  view.up = glm::cross(direction, view.right);
  return view;
}

Result<std::vector<Viewpoint>> viewpoints(std::uint32_t count) {
  if (count == 0 || count > kMaxViewCount)
    return Error{Status::invalid_argument, "number of views is not between 1 and 1024", Error::kNoOffset, std::to_string(count)};
  std::vector<Viewpoint> views;
  views.reserve(count);
  for (const glm::vec3& direction : count == 20 ? dodecahedron_vertices() : fibonacci_sphere(count))
    views.push_back(viewpoint_towards(glm::normalize(direction)));
  return views;
}

}  // namespace coppice::bake
