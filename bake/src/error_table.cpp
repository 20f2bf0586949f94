#include "error_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "leaf_shade.h"
#include "parallel_for.h"
#include "srgb.h"
#include "texture_mips.h"
#include "tree_order.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

constexpr std::uint32_t kLevelCount = 24;
constexpr std::uint32_t kViewCount = 6;
constexpr std::uint32_t kRenderedSizePx = 512;
constexpr std::array<std::uint32_t, 7> kSizesPx = {8, 16, 32, 64, 128, 256, 512};

/// Luminance 0..255, rows top to bottom, square.
using LuminanceImage = std::vector<float>;
/// Mean squared luminance difference at each of kSizesPx.
using SquaredErrors = std::array<double, kSizesPx.size()>;

struct Renderer {
  const BakedPlant* plant = nullptr;
  std::vector<AlphaMask> masks;         ///< per material
  std::vector<float> card_luminance;    ///< per card, linear
  std::vector<Projection> projections;  ///< [kViewCount]
};

Result<Renderer> make_renderer(const BakedPlant& plant) {
  Renderer renderer;
  renderer.plant = &plant;
  COPPICE_TRY(masks, alpha_masks(plant.materials, plant.images));
  renderer.masks = std::move(masks);
  for (const Card& card : plant.card_table)
    renderer.card_luminance.push_back(mean_texel_luminance(plant.materials[card.material], plant.images, renderer.masks[card.material]));
  for (const Viewpoint& view : error_table_viewpoints())
    renderer.projections.push_back(make_projection(view, plant.sphere, kRenderedSizePx));
  return renderer;
}

LuminanceImage render(const Renderer& renderer, std::span<const std::uint32_t> nodes, const Projection& projection) {
  static const glm::vec3 to_light = glm::normalize(glm::vec3(0.4f, 0.8f, 0.45f));
  const BakedPlant& plant = *renderer.plant;
  LuminanceImage image(std::size_t{kRenderedSizePx} * kRenderedSizePx, kWhiteLuminance);
  std::vector<std::uint32_t> depths(image.size(), 0xffffffffu);
  for (const std::uint32_t node : nodes) {
    const Quad quad = node_quad(plant.tree, node);
    const std::uint32_t card_index = plant.tree.nodes[node].card;
    const Card& card = plant.card_table[card_index];
    const float value = shaded_luminance(quad, renderer.card_luminance[card_index], to_light);
    rasterise_leaf(project(projection, quad), card, renderer.masks[card.material], kRenderedSizePx, [&](const QuadFragment& fragment) {
      const std::size_t pixel = static_cast<std::size_t>(fragment.y) * kRenderedSizePx + static_cast<std::size_t>(fragment.x);
      if (fragment.depth >= depths[pixel]) return;
      depths[pixel] = fragment.depth;
      image[pixel] = value;
    });
  }
  return image;
}

/// 2 x 2 box filter.
LuminanceImage halve(const LuminanceImage& image, std::uint32_t size_px) {
  const std::size_t half = size_px / 2;
  LuminanceImage result(half * half);
  for (std::size_t y = 0; y < half; ++y)
    for (std::size_t x = 0; x < half; ++x) {
      const float* top = image.data() + (y * 2) * size_px + x * 2;
      result[y * half + x] = 0.25f * (top[0] + top[1] + top[size_px] + top[size_px + 1]);
    }
  return result;
}

double mean_square(const LuminanceImage& image) {
  double sum = 0.0;
  for (const float value : image) sum += double{value} * value;
  return sum / static_cast<double>(image.size());
}

/// Box filtering is linear: the difference of filtered images is the filtered difference.
SquaredErrors squared_errors(const LuminanceImage& source, const LuminanceImage& cut) {
  LuminanceImage difference(source.size());
  std::ranges::transform(source, cut, difference.begin(), std::minus<>());
  SquaredErrors errors{};
  for (std::size_t size = kSizesPx.size(); size-- > 0;) {
    errors[size] = mean_square(difference);
    if (size > 0) difference = halve(difference, kSizesPx[size]);
  }
  return errors;
}

/// The error in px of mean squared errors, one a view.
float error_px_of(const std::array<SquaredErrors, kViewCount>& errors, std::size_t size) {
  double sum = 0.0;
  for (const SquaredErrors& view_errors : errors) sum += view_errors[size];
  return static_cast<float>(kSizesPx[size] * std::sqrt(sum / kViewCount) / kWhiteLuminance);
}

std::vector<std::uint32_t> measured_leaf_counts(std::uint32_t leaf_count) {
  std::vector<std::uint32_t> counts;
  for (std::uint32_t level = 0; level < kLevelCount; ++level) {
    const double exponent = static_cast<double>(level) / (kLevelCount - 1);
    const auto count = static_cast<std::uint32_t>(std::lround(std::pow(static_cast<double>(leaf_count), exponent)));
    if (counts.empty() || count > counts.back()) counts.push_back(std::min(count, leaf_count));
  }
  return counts;
}

}  // namespace

std::vector<Viewpoint> error_table_viewpoints() {
  const glm::vec3 axis = glm::normalize(glm::vec3(0.36f, 0.48f, 0.80f));
  constexpr float kCosine = 0.64f, kSine = 0.768375f;  // about 50 degrees
  std::vector<Viewpoint> views;
  for (const Viewpoint& view : *viewpoints(kViewCount)) {
    const glm::vec3& d = view.direction;
    const glm::vec3 turned = d * kCosine + glm::cross(axis, d) * kSine + axis * (glm::dot(axis, d) * (1.0f - kCosine));
    views.push_back(viewpoint_towards(glm::normalize(turned)));
  }
  return views;
}

Sphere plant_sphere(const Foliage& foliage, const Mesh& wood, const LeafMeshes& leaf_meshes) {
  glm::vec3 low = foliage.quads.front()[0], high = low;
  const auto include = [&](const glm::vec3& point) { low = glm::min(low, point), high = glm::max(high, point); };
  for (const Quad& quad : foliage.quads) std::ranges::for_each(quad, include);
  std::ranges::for_each(wood.positions, include);
  for (const LeafMeshPart& part : leaf_meshes.parts) std::ranges::for_each(part.mesh.positions, include);
  Sphere sphere{(low + high) * 0.5f, 0.0f};
  const auto reach = [&](const glm::vec3& point) { sphere.radius = std::max(sphere.radius, glm::length(point - sphere.center)); };
  for (const Quad& quad : foliage.quads) std::ranges::for_each(quad, reach);
  std::ranges::for_each(wood.positions, reach);
  for (const LeafMeshPart& part : leaf_meshes.parts) std::ranges::for_each(part.mesh.positions, reach);
  return sphere;
}

Result<ErrorTable> measure_error_table(const BakedPlant& plant, const ProgressFunction& progress) {
  COPPICE_TRY(renderer, make_renderer(plant));
  const std::vector<std::uint32_t> source_nodes = cut_nodes(plant.tree, plant.tree.leaf_count());
  std::vector<LuminanceImage> source(kViewCount);
  parallel_for(std::size_t{kViewCount},
               [&](std::size_t view) { source[view] = render(renderer, source_nodes, renderer.projections[view]); });

  ErrorTable table;
  table.leaf_counts = measured_leaf_counts(plant.tree.leaf_count());
  table.sizes_px.assign(kSizesPx.begin(), kSizesPx.end());
  for (std::size_t level = 0; level < table.leaf_counts.size(); ++level) {
    progress(static_cast<double>(level) / static_cast<double>(table.leaf_counts.size()));
    const std::vector<std::uint32_t> nodes = cut_nodes(plant.tree, table.leaf_counts[level]);
    std::array<SquaredErrors, kViewCount> errors{};
    parallel_for(std::size_t{kViewCount}, [&](std::size_t view) {
      errors[view] = squared_errors(source[view], render(renderer, nodes, renderer.projections[view]));
    });
    for (std::size_t size = 0; size < kSizesPx.size(); ++size) table.error_px.push_back(error_px_of(errors, size));
  }
  for (std::size_t i = table.error_px.size() - kSizesPx.size(); i-- > 0;)
    table.error_px[i] = std::max(table.error_px[i], table.error_px[i + kSizesPx.size()]);
  progress(1.0);
  return table;
}

namespace {

/// An image's linear luminance at one mip level.
struct LuminanceLevel {
  std::uint32_t width = 0, height = 0;
  std::vector<float> luminance;
};

/// What a material shows.
struct Look {
  float plain = 0.0f;                  ///< without an image
  std::vector<LuminanceLevel> levels;  ///< times the base colour
};

Look look_of(const Material& material, const std::vector<Image>& images) {
  constexpr glm::vec3 kLuminance(0.2126f, 0.7152f, 0.0722f);
  Look look{glm::dot(glm::vec3(material.base_color), kLuminance), {}};
  if (material.image == kNone) return look;
  for (const Image& level : mip_levels(images[material.image], material.alpha_cutoff)) {
    LuminanceLevel& of_level = look.levels.emplace_back(LuminanceLevel{level.width, level.height, {}});
    for (std::size_t i = 0; i < level.rgba.size(); i += 4) {
      const auto channel = [&](std::size_t c) { return linear_from_srgb(static_cast<float>(level.rgba[i + c]) / 255.0f); };
      of_level.luminance.push_back(glm::dot(glm::vec3(channel(0), channel(1), channel(2)) * glm::vec3(material.base_color), kLuminance));
    }
  }
  return look;
}

/// The mip level whose texels are about as large as pixels.
std::size_t level_of(const Look& look, const std::array<ProjectedPoint, 3>& points, const std::array<glm::vec2, 3>& uvs) {
  const glm::dvec2 ab(points[1].x - points[0].x, points[1].y - points[0].y), ac(points[2].x - points[0].x, points[2].y - points[0].y);
  const double pixels = std::abs(ab.x * ac.y - ab.y * ac.x) / (double{kSubpixels} * kSubpixels);
  const glm::dvec2 uv_ab(uvs[1] - uvs[0]), uv_ac(uvs[2] - uvs[0]);
  const double texels = std::abs(uv_ab.x * uv_ac.y - uv_ab.y * uv_ac.x) * look.levels.front().width * look.levels.front().height;
  if (!(texels > pixels) || !(pixels > 0.0)) return 0;
  return std::min(static_cast<std::size_t>(std::lround(0.5 * std::log2(texels / pixels))), look.levels.size() - 1);
}

/// Draws triangles in the colours of their images.
class TexturedCanvas {
 public:
  TexturedCanvas(const Projection& projection, const std::vector<Look>& looks, const std::vector<AlphaMask>& masks)
      : projection_(projection), looks_(looks), masks_(masks), depths_(image.size(), 0xffffffffu) {}

  void draw(const std::array<glm::vec3, 3>& corners, const std::array<glm::vec2, 3>& uvs, std::uint32_t material) {
    static const glm::vec3 to_light = glm::normalize(glm::vec3(0.4f, 0.8f, 0.45f));
    const glm::vec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const float length = glm::length(normal);
    const float cosine = length > 0.0f ? std::abs(glm::dot(normal, to_light)) / length : 0.0f;
    const std::array points{project(projection_, corners[0]), project(projection_, corners[1]), project(projection_, corners[2])};
    const RasterTriangle triangle(points[0], points[1], points[2]);
    const Look& look = looks_[material];
    const std::size_t level = look.levels.empty() ? 0 : level_of(look, points, uvs);
    const int last_row = std::min(triangle.last_row(), static_cast<std::int32_t>(kRenderedSizePx) - 1);
    for (std::int32_t y = std::max(triangle.first_row(), 0); y <= last_row; ++y) {
      const Span span = triangle.row(y, kRenderedSizePx);
      for (std::int32_t x = span.first; x <= span.last; ++x) {
        const std::size_t pixel = static_cast<std::size_t>(y) * kRenderedSizePx + static_cast<std::size_t>(x);
        const std::uint32_t depth = triangle.depth(x, y);
        if (depth >= depths_[pixel]) continue;
        const std::array<double, 3> weight = triangle.weights(x, y);
        const glm::dvec2 uv = glm::dvec2(uvs[0]) * weight[0] + glm::dvec2(uvs[1]) * weight[1] + glm::dvec2(uvs[2]) * weight[2];
        if (masks_[material].is_hole(uv)) continue;
        depths_[pixel] = depth;
        image[pixel] = lambert_luminance(look.levels.empty() ? look.plain : luminance_at(look.levels[level], uv), cosine);
      }
    }
  }

  LuminanceImage image = LuminanceImage(std::size_t{kRenderedSizePx} * kRenderedSizePx, kWhiteLuminance);

 private:
  static float luminance_at(const LuminanceLevel& level, const glm::dvec2& uv) {
    return level.luminance[std::size_t{wrapped_texel(uv.y, level.height)} * level.width + wrapped_texel(uv.x, level.width)];
  }

  const Projection& projection_;
  const std::vector<Look>& looks_;
  const std::vector<AlphaMask>& masks_;
  std::vector<std::uint32_t> depths_;
};

void draw_quads(const BakedPlant& plant, std::span<const std::uint32_t> nodes, TexturedCanvas& canvas) {
  for (const std::uint32_t node : nodes) {
    const Quad quad = node_quad(plant.tree, node);
    const Card& card = plant.card_table[plant.tree.nodes[node].card];
    for (const std::size_t second : {std::size_t{1}, std::size_t{2}})
      canvas.draw({quad[0], quad[second], quad[second + 1]}, {card.uv[0], card.uv[second], card.uv[second + 1]}, card.material);
  }
}

void draw_meshes(const LeafMeshes& meshes, TexturedCanvas& canvas) {
  for (const LeafMeshPart& part : meshes.parts)
    for (std::size_t t = 0; t < part.mesh.triangle_materials.size(); ++t) {
      std::array<glm::vec3, 3> corners{};
      std::array<glm::vec2, 3> uvs{};
      for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = part.mesh.positions[part.mesh.indices[3 * t + k]];
        uvs[k] = part.mesh.uvs[part.mesh.indices[3 * t + k]];
      }
      canvas.draw(corners, uvs, part.mesh.triangle_materials[t]);
    }
}

}  // namespace

Result<std::vector<float>> measure_leaf_mesh_error(const BakedPlant& plant) {
  COPPICE_TRY(renderer, make_renderer(plant));
  std::vector<bool> shown(plant.materials.size(), false);
  for (const Card& card : plant.card_table) shown[card.material] = true;
  for (const LeafMeshPart& part : plant.leaf_meshes.parts)
    for (const std::uint32_t material : part.mesh.triangle_materials) shown[material] = true;
  std::vector<Look> looks(plant.materials.size());
  parallel_for(looks.size(), [&](std::size_t material) {
    if (shown[material]) looks[material] = look_of(plant.materials[material], plant.images);
  });

  const std::vector<std::uint32_t> nodes = cut_nodes(plant.tree, plant.tree.leaf_count());
  std::array<SquaredErrors, kViewCount> errors{};
  parallel_for(std::size_t{kViewCount}, [&](std::size_t view) {
    TexturedCanvas quads(renderer.projections[view], looks, renderer.masks), meshes(renderer.projections[view], looks, renderer.masks);
    draw_quads(plant, nodes, quads);
    draw_meshes(plant.leaf_meshes, meshes);
    errors[view] = squared_errors(meshes.image, quads.image);
  });
  std::vector<float> error_px;
  for (std::size_t size = 0; size < kSizesPx.size(); ++size)
    error_px.push_back(std::max(error_px_of(errors, size), error_px.empty() ? 0.0f : error_px.back()));
  return error_px;
}

}  // namespace coppice::bake
