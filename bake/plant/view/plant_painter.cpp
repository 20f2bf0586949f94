#include "plant_painter.h"

#include <cmath>

#include <glm/geometric.hpp>

#include "alpha_mask.h"

namespace coppice::bake {

PaintedTriangle painted_triangle(const Mesh& mesh, std::size_t triangle) {
  PaintedTriangle painted;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t vertex = mesh.indices[3 * triangle + k];
    painted.points[k] = mesh.positions[vertex];
    painted.uvs[k] = mesh.uvs[vertex];
  }
  painted.material = mesh.triangle_materials[triangle];
  return painted;
}

PlantPainter::PlantPainter(const std::vector<Material>& materials, const std::vector<Image>& images, const Viewpoint& view,
                           const Sphere& sphere, std::uint32_t size_px, const glm::vec3& background)
    : materials_(materials),
      images_(images),
      direction_(view.direction),
      projection_(make_projection(view, sphere, size_px)),
      size_px_(size_px),
      colors_(std::size_t{size_px} * size_px, background),
      depths_(colors_.size(), std::numeric_limits<std::uint32_t>::max()) {}

double PlantPainter::facing(const PaintedTriangle& triangle) const {
  const auto& [a, b, c] = triangle.points;
  const glm::dvec3 across = glm::cross(glm::dvec3(b - a), glm::dvec3(c - a));
  const double length = glm::length(across);
  return length > 0.0 ? std::abs(glm::dot(across, direction_)) / length : 1.0;
}

glm::dvec2 PlantPainter::uv_at(const PaintedTriangle& triangle, const std::array<double, 3>& weights) {
  glm::dvec2 uv(0.0);
  for (std::size_t k = 0; k < 3; ++k) uv += weights[k] * glm::dvec2(triangle.uvs[k]);
  return uv;
}

bool PlantPainter::is_hole(const Material& material, const glm::dvec2& uv) const {
  if (material.alpha_cutoff == 0.0f || material.image == kNone) return false;
  return static_cast<float>(texel_at(images_[material.image], uv)[3]) < material.alpha_cutoff * 255.0f;
}

std::vector<glm::vec3> shrunk_picture(const std::vector<glm::vec3>& colors, std::uint32_t size_px, std::uint32_t factor) {
  const std::size_t wide = size_px, small = size_px / factor;
  std::vector<glm::vec3> means(small * small, glm::vec3(0.0f));
  for (std::size_t y = 0; y < small * factor; ++y)
    for (std::size_t x = 0; x < small * factor; ++x) means[y / factor * small + x / factor] += colors[y * wide + x];
  for (glm::vec3& mean : means) mean /= static_cast<float>(factor * factor);
  return means;
}

}  // namespace coppice::bake
