#include "leaf_preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <stb_image_write.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "alpha_mask.h"
#include "parallel_for.h"
#include "raster.h"
#include "viewpoints.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

// Drawn so much larger and averaged.
constexpr std::uint32_t kSupersampling = 2;
constexpr std::uint32_t kDrawnPx = kSupersampling * kPreviewSizePx;
constexpr glm::dvec3 kWood(0.45, 0.29, 0.16);

/// Green by a number: hue from yellow-green to blue-green, light and dark.
glm::dvec3 leaf_color(std::uint32_t leaf) {
  // Neighbours in the file get hues far apart: steps of the golden ratio never fall into a short cycle.
  const double turn = std::fmod(leaf * 0.6180339887498949, 1.0), shade = std::fmod(leaf * 0.7548776662466927, 1.0);
  const double yellow = std::max(0.0, 1.0 - 2.0 * turn), blue = std::max(0.0, 2.0 * turn - 1.0);
  return (0.65 + 0.35 * shade) * glm::dvec3(0.1 + 0.6 * yellow, 0.85, 0.1 + 0.6 * blue);
}

struct Canvas {
  std::vector<glm::vec3> colors = std::vector<glm::vec3>(std::size_t{kDrawnPx} * kDrawnPx, glm::vec3(1.0f));
  std::vector<std::uint32_t> depths = std::vector<std::uint32_t>(colors.size(), std::numeric_limits<std::uint32_t>::max());
};

class Painter {
 public:
  Painter(const Plant& plant, const Viewpoint& view, const Sphere& sphere)
      : plant_(plant), view_(view), projection_(make_projection(view, sphere, kDrawnPx)) {}

  void draw(const Mesh& mesh, std::size_t triangle, const glm::dvec3& color) {
    const std::uint32_t* corners = &mesh.indices[3 * triangle];
    const std::array<glm::vec3, 3> points{mesh.positions[corners[0]], mesh.positions[corners[1]], mesh.positions[corners[2]]};
    const RasterTriangle raster(project(projection_, points[0]), project(projection_, points[1]), project(projection_, points[2]));
    const glm::dvec3 across = glm::cross(glm::dvec3(points[1] - points[0]), glm::dvec3(points[2] - points[0]));
    const double length = glm::length(across);
    const double facing = length > 0.0 ? std::abs(glm::dot(across, glm::dvec3(view_.direction))) / length : 1.0;
    const glm::vec3 shaded(color * (0.55 + 0.45 * facing));
    const Material& material = plant_.materials[mesh.triangle_materials[triangle]];
    for (std::int32_t y = std::max(raster.first_row(), 0); y <= std::min<std::int32_t>(raster.last_row(), kDrawnPx - 1); ++y) {
      const Span span = raster.row(y, kDrawnPx);
      const DepthRow depths = raster.depths(y);
      for (std::int32_t x = span.first; x <= span.last; ++x) {
        const std::size_t pixel = static_cast<std::size_t>(y) * kDrawnPx + static_cast<std::size_t>(x);
        const std::uint32_t depth = depths.at(x);
        if (depth >= canvas_.depths[pixel] || is_hole(mesh, corners, material, raster.weights(x, y))) continue;
        canvas_.depths[pixel] = depth;
        canvas_.colors[pixel] = shaded;
      }
    }
  }

  Canvas take() { return std::move(canvas_); }

 private:
  [[nodiscard]] bool is_hole(const Mesh& mesh, const std::uint32_t* corners, const Material& material,
                             const std::array<double, 3>& weights) const {
    if (material.alpha_cutoff == 0.0f || material.image == kNone) return false;
    const Image& image = plant_.images[material.image];
    glm::dvec2 uv(0.0);
    for (std::size_t k = 0; k < 3; ++k) uv += weights[k] * glm::dvec2(mesh.uvs[corners[k]]);
    const std::size_t at = std::size_t{wrapped_texel(uv.y, image.height)} * image.width + wrapped_texel(uv.x, image.width);
    return static_cast<float>(image.rgba[4 * at + 3]) < material.alpha_cutoff * 255.0f;
  }

  const Plant& plant_;
  const Viewpoint& view_;
  Projection projection_;
  Canvas canvas_;
};

Sphere bounds(const Plant& plant) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for (const glm::vec3& position : mesh->positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
  Sphere sphere;
  if (low.x > high.x) return sphere;
  sphere.center = 0.5f * (low + high);
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for (const glm::vec3& position : mesh->positions) sphere.radius = std::max(sphere.radius, glm::distance(sphere.center, position));
  return sphere;
}

Canvas draw_view(const Plant& plant, const Viewpoint& view, const Sphere& sphere) {
  Painter painter(plant, view, sphere);
  for (std::size_t t = 0; t < plant.wood.triangle_materials.size(); ++t) painter.draw(plant.wood, t, kWood);
  for (std::uint32_t leaf = 0; leaf < plant.leaves.size(); ++leaf)
    for (std::uint32_t k = 0; k < plant.leaves[leaf].triangle_count; ++k)
      painter.draw(plant.foliage, std::size_t{plant.leaves[leaf].first_triangle} + k, leaf_color(leaf));
  return painter.take();
}

/// Averages a canvas into its columns of the picture.
void shrink(const Canvas& canvas, std::size_t view, std::size_t view_count, std::vector<std::uint8_t>& rgb) {
  for (std::size_t y = 0; y < kPreviewSizePx; ++y)
    for (std::size_t x = 0; x < kPreviewSizePx; ++x) {
      glm::vec3 sum(0.0f);
      for (std::size_t i = 0; i < kSupersampling; ++i)
        for (std::size_t k = 0; k < kSupersampling; ++k) sum += canvas.colors[(y * kSupersampling + i) * kDrawnPx + x * kSupersampling + k];
      std::uint8_t* pixel = &rgb[3 * ((y * view_count + view) * kPreviewSizePx + x)];
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(std::lround(255.0f * sum[c] / static_cast<float>(kSupersampling * kSupersampling)));
    }
}

}  // namespace

Result<std::vector<std::uint8_t>> render_leaf_preview_png(const Plant& plant) {
  const std::array views{viewpoint_towards({0.0f, 0.0f, 1.0f}), viewpoint_towards({1.0f, 0.0f, 0.0f}),
                         viewpoint_towards(glm::normalize(glm::vec3(0.4f, 1.0f, 0.6f)))};
  const Sphere sphere = bounds(plant);
  std::vector<std::uint8_t> rgb(std::size_t{3} * views.size() * kPreviewSizePx * kPreviewSizePx);
  parallel_for(views.size(), [&](std::size_t i) { shrink(draw_view(plant, views[i], sphere), i, views.size(), rgb); });

  std::vector<std::uint8_t> png;
  const auto append = [](void* context, void* data, int size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    auto* out = static_cast<std::vector<std::uint8_t>*>(context);
    out->insert(out->end(), bytes, bytes + size);
  };
  constexpr int kWidth = static_cast<int>(3 * kPreviewSizePx), kHeight = static_cast<int>(kPreviewSizePx);
  if (stbi_write_png_to_func(append, &png, kWidth, kHeight, 3, rgb.data(), 3 * kWidth) == 0)
    return Error{Status::internal, "the preview cannot be encoded as PNG"};
  return png;
}

}  // namespace coppice::bake
