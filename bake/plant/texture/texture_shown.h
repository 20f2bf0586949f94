#pragma once

// Which texels of an image a plant shows, how much surface shows each, and in which colour.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

using UvTriangle = std::array<glm::vec2, 3>;

inline UvTriangle triangle_uvs(const Mesh& mesh, std::size_t triangle) {
  const auto uv = [&](std::size_t k) { return mesh.uvs[mesh.indices[3 * triangle + k]]; };
  return {uv(0), uv(1), uv(2)};
}

inline double triangle_area_m2(const Mesh& mesh, std::size_t triangle) {
  const auto at = [&](std::size_t k) { return glm::dvec3(mesh.positions[mesh.indices[3 * triangle + k]]); };
  return 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
}

/// Sums the linear colour of some surface over the area that the alpha test keeps.
struct ColorSum {
  glm::dvec3 color_area_m2{0.0};
  double area_m2 = 0.0;

  void add(const ColorSum& other) {
    color_area_m2 += other.color_area_m2;
    area_m2 += other.area_m2;
  }
  [[nodiscard]] glm::dvec3 mean() const { return area_m2 > 0.0 ? color_area_m2 / area_m2 : glm::dvec3(0.0); }
};

/// Largest difference of two linear colours in a channel, in sRGB, 0..1.
double color_difference(const glm::dvec3& a, const glm::dvec3& b);

/// Samples what a triangle of this area shows of the material's image; white without an image.
ColorSum triangle_color(const Material& material, const std::vector<Image>& images, const UvTriangle& uvs, double area_m2);

/// Sums over triangles how much of their area shows each texel of an image, which repeats. Sums are whole numbers, so the order of
/// triangles does not matter.
class ShownArea {
 public:
  explicit ShownArea(glm::uvec2 side) : side_(side), steps_(std::size_t{side.x + 1} * side.y) {}

  /// share  the triangle's part of all area that shows the image, in [0, 1]
  void add(const UvTriangle& uvs, double share);
  /// [side.x * side.y] row-major, relative; 0 for texels of which nothing, or hardly more than rounding, is shown.
  [[nodiscard]] std::vector<float> weights() const;

 private:
  void add_everywhere(double share);
  void add_line(const std::array<glm::dvec2, 3>& points, double share);
  /// What a covered texel gets: a part of the share, and its coverage.
  struct Density {
    double area = 0.0, coverage = 0.0;
  };
  void add_span(std::int64_t row, double first, double last, const Density& density);
  void add_within(std::size_t row, double first, double last, const Density& density);

  glm::uvec2 side_;
  /// The difference of a texel to the one on its left, in whole units.
  struct Step {
    std::int64_t area = 0, coverage = 0;
  };
  std::vector<Step> steps_;  ///< [side.y * (side.x + 1)] row-major
};

/// Sets Image::shown of every image that a material shows in its colour: the area of the triangles at each texel.
void measure_shown_texels(Plant& plant);

}  // namespace coppice::bake
