#pragma once

// Paints pictures of plants for people with the baker's rasteriser: the nearest surface at each pixel, with alpha masks. Nothing is
// computed from them.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "plant.h"
#include "raster.h"
#include "viewpoints.h"

namespace coppice::bake {

struct PaintedTriangle {
  std::array<glm::vec3, 3> points{};
  std::array<glm::vec2, 3> uvs{};
  std::uint32_t material = 0;
};

PaintedTriangle painted_triangle(const Mesh& mesh, std::size_t triangle);

/// Paints a square picture at its full size; shrunk_picture reduces it. Holds references to materials and images, which must be as
/// alpha_masks requires.
class PlantPainter {
 public:
  /// background  colour of pixels that show nothing, in the space of the other colours
  PlantPainter(const std::vector<Material>& materials, const std::vector<Image>& images, const Viewpoint& view, const Sphere& sphere,
               std::uint32_t size_px, const glm::vec3& background);

  /// Paints the triangle where it is nearest and no hole. is_transparent(pixel) leaves out pixels by stochastic transparency, color(uv) is
  /// the RGB colour.
  template <class IsTransparent, class Color>
  void paint(const PaintedTriangle& triangle, const IsTransparent& is_transparent, const Color& color) {
    const RasterTriangle raster(project(projection_, triangle.points[0]), project(projection_, triangle.points[1]),
                                project(projection_, triangle.points[2]));
    const auto size = static_cast<std::int32_t>(size_px_);
    for (std::int32_t y = std::max(raster.first_row(), 0); y <= std::min(raster.last_row(), size - 1); ++y) {
      const Span span = raster.row(y, size);
      const DepthRow depths = raster.depths(y);
      for (std::int32_t x = span.first; x <= span.last; ++x) {
        const std::size_t pixel = static_cast<std::size_t>(y) * size_px_ + static_cast<std::size_t>(x);
        const std::uint32_t depth = depths.at(x);
        if (depth >= depths_[pixel] || is_transparent(pixel)) continue;
        const glm::dvec2 uv = uv_at(triangle, raster.weights(x, y));
        if (is_hole(materials_[triangle.material], uv)) continue;
        depths_[pixel] = depth;
        colors_[pixel] = color(uv);
      }
    }
  }

  /// The cosine between the triangle's normal and the line of sight, 0..1; 1 without area.
  [[nodiscard]] double facing(const PaintedTriangle& triangle) const;

  /// [size_px^2] rows top to bottom
  [[nodiscard]] const std::vector<glm::vec3>& colors() const { return colors_; }

 private:
  static glm::dvec2 uv_at(const PaintedTriangle& triangle, const std::array<double, 3>& weights);
  [[nodiscard]] bool is_hole(const Material& material, const glm::dvec2& uv) const;

  const std::vector<Material>& materials_;
  const std::vector<Image>& images_;
  glm::dvec3 direction_;
  Projection projection_;
  std::uint32_t size_px_;
  std::vector<glm::vec3> colors_;
  std::vector<std::uint32_t> depths_;
};

/// Averages blocks of factor x factor colours. size_px  the picture's side, a multiple of the factor
std::vector<glm::vec3> shrunk_picture(const std::vector<glm::vec3>& colors, std::uint32_t size_px, std::uint32_t factor);

}  // namespace coppice::bake
