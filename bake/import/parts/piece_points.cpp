#include "piece_points.h"

#include <algorithm>
#include <map>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "weld.h"

namespace coppice::bake {
namespace {

/// The smallest of a triangle's three heights.
double height_m(const Mesh& mesh, std::size_t triangle) {
  const std::uint32_t* corners = &mesh.indices[3 * triangle];
  const glm::dvec3 a(mesh.positions[corners[0]]), b(mesh.positions[corners[1]]), c(mesh.positions[corners[2]]);
  const double longest_m = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  return longest_m > 0.0 ? glm::length(glm::cross(b - a, c - a)) / longest_m : 0.0;
}

}  // namespace

double box_diagonal_m(const Mesh& mesh) {
  if (mesh.positions.empty()) return 0.0;
  glm::vec3 low = mesh.positions[0], high = low;
  for (const glm::vec3& position : mesh.positions) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  return glm::distance(glm::dvec3(low), glm::dvec3(high));
}

Points::Points(const Mesh& mesh, const std::vector<std::uint32_t>& welded)
    : corners_(mesh.indices.size()), count_(welded.size()), has_area_(mesh.triangle_materials.size()) {
  std::vector<std::uint32_t> material_of(welded.size(), kNone);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> others;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const std::uint32_t point = welded[mesh.indices[i]], material = mesh.triangle_materials[i / 3];
    if (material_of[point] == kNone) material_of[point] = material;
    if (material_of[point] == material) {
      corners_[i] = point;
      continue;
    }
    const auto [found, is_new] = others.try_emplace({point, material}, static_cast<std::uint32_t>(count_));
    if (is_new) ++count_;
    corners_[i] = found->second;
  }
  const double tolerance_m = box_diagonal_m(mesh) * static_cast<double>(kWeldTolerance);
  for (std::size_t t = 0; t < has_area_.size(); ++t) has_area_[t] = height_m(mesh, t) > tolerance_m;
}

}  // namespace coppice::bake
