#include "bounds.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "text_number.h"

namespace coppice::bake {
namespace {

// The tallest tree alive is 116 m high, duckweed a few millimetres wide.
constexpr double kLargestPlant_m = 120.0, kSmallestPlant_m = 0.01;
/// A warning suggests the first power of ten that brings a plant within these sizes: most plants are.
constexpr double kLargestUsual_m = 60.0, kSmallestUsual_m = 0.1;

std::string number_text(double value) {
  // "%.3g" would write 1234.5 as 1.23e+03.
  return formatted(std::abs(value) >= 1000.0 && std::abs(value) < 1e6 ? "%.0f" : "%.3g", value);
}

}  // namespace

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

std::array<double, 3> plant_size_m(const Plant& plant) {
  PointBox<glm::dvec3> box;
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for (const glm::vec3& position : mesh->positions) box.add(position);
  const glm::dvec3 size = glm::max(box.extent(), 0.0);  // 0 without points
  return {size.x, size.y, size.z};
}

std::string size_text(const std::array<double, 3>& size_m) {
  return number_text(size_m[1]) + " m high, " + number_text(size_m[0]) + " x " + number_text(size_m[2]) + " m wide";
}

std::string size_warning(const std::array<double, 3>& size_m, double metres_per_unit) {
  const double largest = *std::ranges::max_element(size_m);
  const bool is_large = largest > kLargestPlant_m;
  if (!is_large && (largest >= kSmallestPlant_m || largest <= 0.0)) return {};
  double factor = is_large ? 0.01 : 100.0;
  while (is_large ? factor * largest > kLargestUsual_m : factor * largest < kSmallestUsual_m) factor *= is_large ? 0.1 : 10.0;
  const double unit_m = metres_per_unit * factor;
  const bool is_cm = std::abs(unit_m - 0.01) < 1e-9, is_mm = std::abs(unit_m - 0.001) < 1e-9;
  const std::string unit = is_cm ? "cm" : is_mm ? "mm" : number_text(unit_m);
  const std::string guess = is_cm ? "centimetres" : is_mm ? "millimetres" : "units of " + unit + " m";
  return size_text(size_m) + ": looks like " + guess + ": --unit " + unit;
}

}  // namespace coppice::bake
