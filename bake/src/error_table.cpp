#include "error_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "leaf_shade.h"
#include "parallel_for.h"
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

Sphere plant_sphere(const Foliage& foliage, const Mesh& wood) {
  glm::vec3 low = foliage.quads.front()[0], high = low;
  const auto include = [&](const glm::vec3& point) { low = glm::min(low, point), high = glm::max(high, point); };
  for (const Quad& quad : foliage.quads) std::ranges::for_each(quad, include);
  std::ranges::for_each(wood.positions, include);
  Sphere sphere{(low + high) * 0.5f, 0.0f};
  const auto reach = [&](const glm::vec3& point) { sphere.radius = std::max(sphere.radius, glm::length(point - sphere.center)); };
  for (const Quad& quad : foliage.quads) std::ranges::for_each(quad, reach);
  std::ranges::for_each(wood.positions, reach);
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
    for (std::size_t size = 0; size < kSizesPx.size(); ++size) {
      double sum = 0.0;
      for (const SquaredErrors& view_errors : errors) sum += view_errors[size];
      table.error_px.push_back(static_cast<float>(kSizesPx[size] * std::sqrt(sum / kViewCount) / kWhiteLuminance));
    }
  }
  for (std::size_t i = table.error_px.size() - kSizesPx.size(); i-- > 0;)
    table.error_px[i] = std::max(table.error_px[i], table.error_px[i + kSizesPx.size()]);
  progress(1.0);
  return table;
}

}  // namespace coppice::bake
