#include "error_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "alpha_mask.h"
#include "error_image.h"
#include "leaf_shade.h"
#include "parallel_for.h"
#include "tree_order.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

constexpr std::uint32_t kLevelCount = 24;

/// Luminance, red less luminance, blue less luminance.
using Color = std::array<float, 3>;
using ColorImage = std::array<LuminanceImage, 3>;

/// albedo  linear
Color shaded_color(const glm::vec3& albedo, float cosine) {
  const glm::vec2 of_color = chroma(albedo, cosine);
  return {plant_luminance(lambert_luminance(luminance(albedo), cosine)), of_color.x, of_color.y};
}

struct Renderer {
  const BakedPlant* plant = nullptr;
  std::vector<AlphaMask> masks;         ///< per material
  std::vector<glm::vec3> card_albedo;   ///< per card, linear
  std::vector<Projection> projections;  ///< [kErrorViewCount]
  Color background{};                   ///< white, as colourful as the leaves: what they cover is a matter of luminance alone
};

Color background_of(const BakedPlant& plant, const std::vector<glm::vec3>& card_albedo) {
  glm::dvec2 sum(0.0);
  double area_m2 = 0.0;
  for (const std::uint32_t node : cut_nodes(plant.tree, plant.tree.leaf_count())) {
    const Quad quad = node_quad(plant.tree, node);
    const double leaf_m2 = static_cast<double>(glm::length(glm::cross(quad[2] - quad[0], quad[3] - quad[1])));
    sum += leaf_m2 * glm::dvec2(chroma(card_albedo[plant.tree.nodes[node].card]));
    area_m2 += leaf_m2;
  }
  const glm::vec2 mean(area_m2 > 0.0 ? sum / area_m2 : sum);
  return {kWhiteLuminance, mean.x, mean.y};
}

Result<Renderer> make_renderer(const BakedPlant& plant) {
  Renderer renderer;
  renderer.plant = &plant;
  COPPICE_TRY(masks, alpha_masks(plant.materials, plant.images));
  renderer.masks = std::move(masks);
  const std::vector<glm::vec3> colors = mean_texel_colors(plant.materials, plant.images, renderer.masks);
  for (const Card& card : plant.card_table) renderer.card_albedo.push_back(colors[card.material]);
  renderer.background = background_of(plant, renderer.card_albedo);
  renderer.projections = error_projections(plant.sphere);
  return renderer;
}

ColorImage render(const Renderer& renderer, std::span<const std::uint32_t> nodes, const Projection& projection) {
  const BakedPlant& plant = *renderer.plant;
  std::vector<std::uint32_t> depths(std::size_t{kErrorImagePx} * kErrorImagePx, 0xffffffffu);
  ColorImage image;
  for (std::size_t channel = 0; channel < image.size(); ++channel) image[channel].assign(depths.size(), renderer.background[channel]);
  for (const std::uint32_t node : nodes) {
    const Quad quad = node_quad(plant.tree, node);
    const std::uint32_t card_index = plant.tree.nodes[node].card;
    const Card& card = plant.card_table[card_index];
    const Color color = shaded_color(renderer.card_albedo[card_index], two_sided_cosine(quad, error_light()));
    rasterise_leaf(project(projection, quad), card, renderer.masks[card.material], kErrorImagePx, [&](const QuadFragment& fragment) {
      const std::size_t pixel = static_cast<std::size_t>(fragment.y) * kErrorImagePx + static_cast<std::size_t>(fragment.x);
      if (fragment.depth >= depths[pixel]) return;
      depths[pixel] = fragment.depth;
      for (std::size_t channel = 0; channel < image.size(); ++channel) image[channel][pixel] = color[channel];
    });
  }
  return image;
}

/// Of luminance, and a third of what the differences of colour add: about what red, green and blue have in the mean.
SquaredErrors squared_color_errors(const ColorImage& source, const ColorImage& other) {
  SquaredErrors errors = squared_errors(source[0], other[0]);
  for (const std::size_t channel : {std::size_t{1}, std::size_t{2}}) {
    const SquaredErrors of_channel = squared_errors(source[channel], other[channel]);
    for (std::size_t size = 0; size < errors.size(); ++size) errors[size] += of_channel[size] / 3.0;
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

Result<ErrorTable> measure_error_table(const BakedPlant& plant, const ProgressFunction& progress) {
  COPPICE_TRY(renderer, make_renderer(plant));
  const std::vector<std::uint32_t> source_nodes = cut_nodes(plant.tree, plant.tree.leaf_count());
  std::vector<ColorImage> source(kErrorViewCount);
  parallel_for(std::size_t{kErrorViewCount},
               [&](std::size_t view) { source[view] = render(renderer, source_nodes, renderer.projections[view]); });

  ErrorTable table;
  table.leaf_counts = measured_leaf_counts(plant.tree.leaf_count());
  table.sizes_px.assign(kErrorSizesPx.begin(), kErrorSizesPx.end());
  for (std::size_t level = 0; level < table.leaf_counts.size(); ++level) {
    progress(static_cast<double>(level) / static_cast<double>(table.leaf_counts.size()));
    const std::vector<std::uint32_t> nodes = cut_nodes(plant.tree, table.leaf_counts[level]);
    std::array<SquaredErrors, kErrorViewCount> errors{};
    parallel_for(std::size_t{kErrorViewCount}, [&](std::size_t view) {
      errors[view] = squared_color_errors(source[view], render(renderer, nodes, renderer.projections[view]));
    });
    for (std::size_t size = 0; size < kErrorSizesPx.size(); ++size) table.error_px.push_back(error_px_of(errors, size));
  }
  for (std::size_t i = table.error_px.size() - kErrorSizesPx.size(); i-- > 0;)
    table.error_px[i] = std::max(table.error_px[i], table.error_px[i + kErrorSizesPx.size()]);
  progress(1.0);
  return table;
}

}  // namespace coppice::bake
