#include "leaf_preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <stb_image_write.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "parallel_for.h"
#include "plant_painter.h"
#include "viewpoints.h"

namespace coppice::bake {
namespace {

// The picture is drawn so many times larger, and averaged.
constexpr std::uint32_t kSupersampling = 2;
constexpr glm::dvec3 kWood(0.45, 0.29, 0.16);

/// A green for each number: hue from yellow-green to blue-green, light and dark.
glm::dvec3 leaf_color(std::uint32_t leaf) {
  // Neighbours in the file get hues far apart: steps of the golden ratio never fall into a short cycle.
  const double turn = std::fmod(leaf * 0.6180339887498949, 1.0), shade = std::fmod(leaf * 0.7548776662466927, 1.0);
  const double yellow = std::max(0.0, 1.0 - 2.0 * turn), blue = std::max(0.0, 2.0 * turn - 1.0);
  return (0.65 + 0.35 * shade) * glm::dvec3(0.1 + 0.6 * yellow, 0.85, 0.1 + 0.6 * blue);
}

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

/// Draws one view of the plant into its columns of the picture.
void draw_view(const Plant& plant, const Viewpoint& viewpoint, const Sphere& sphere, std::size_t view, std::size_t view_count,
               std::vector<std::uint8_t>& rgb) {
  PlantPainter painter(plant.materials, plant.images, viewpoint, sphere, kSupersampling * kPreviewSizePx, glm::vec3(1.0f));
  const auto paint = [&painter](const Mesh& mesh, std::size_t t, const glm::dvec3& color) {
    const PaintedTriangle triangle = painted_triangle(mesh, t);
    const glm::vec3 shaded(color * (0.55 + 0.45 * painter.facing(triangle)));
    painter.paint(
        triangle, [](std::size_t) { return false; }, [&shaded](const glm::dvec2&) { return shaded; });
  };
  for (std::size_t t = 0; t < plant.wood.triangle_materials.size(); ++t) paint(plant.wood, t, kWood);
  for (std::uint32_t leaf = 0; leaf < plant.leaves.size(); ++leaf)
    for (std::uint32_t k = 0; k < plant.leaves[leaf].triangle_count; ++k)
      paint(plant.foliage, std::size_t{plant.leaves[leaf].first_triangle} + k, leaf_color(leaf));
  const std::vector<glm::vec3> colors = shrunk_picture(painter.colors(), kSupersampling * kPreviewSizePx, kSupersampling);
  for (std::size_t y = 0; y < kPreviewSizePx; ++y)
    for (std::size_t x = 0; x < kPreviewSizePx; ++x) {
      std::uint8_t* pixel = &rgb[3 * ((y * view_count + view) * kPreviewSizePx + x)];
      for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(std::lround(255.0f * colors[y * kPreviewSizePx + x][c]));
    }
}

}  // namespace

Result<std::vector<std::uint8_t>> render_leaf_preview_png(const Plant& plant) {
  const std::array views{viewpoint_towards({0.0f, 0.0f, 1.0f}), viewpoint_towards({1.0f, 0.0f, 0.0f}),
                         viewpoint_towards(glm::normalize(glm::vec3(0.4f, 1.0f, 0.6f)))};
  const Sphere sphere = bounds(plant);
  std::vector<std::uint8_t> rgb(std::size_t{3} * views.size() * kPreviewSizePx * kPreviewSizePx);
  parallel_for(views.size(), [&](std::size_t i) { draw_view(plant, views[i], sphere, i, views.size(), rgb); });

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
