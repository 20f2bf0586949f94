#include "error_table.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "alpha_mask.h"
#include "error_image.h"
#include "leaf_shade.h"
#include "parallel_for.h"
#include "tree_order.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

constexpr std::uint32_t kLevelCount = 24;
/// Cuts of up to so many leaves are judged by their coverage too. In larger ones squares tell, and a draft's coverage does not call for all
/// of its leaves.
constexpr std::size_t kFewLeaves = 64;

/// A sun of the error table, and the share of its light that shines through leaves.
struct Sun {
  glm::vec3 to_light;
  float translucency = 0.0f;
};
/// A high sun and a low one on the other side, which does not shine through.
const std::array<Sun, 2>& suns() {
  static const std::array suns{Sun{error_light(), kTranslucency}, Sun{glm::normalize(glm::vec3(-0.7f, 0.3f, -0.6f)), 0.0f}};
  return suns;
}

/// Luminance under each sun, red minus luminance and blue minus luminance, coverage times kCoverage.
using Color = std::array<float, 5>;
using ColorImage = std::array<LuminanceImage, 5>;
enum Channel : std::size_t { kFirstSun, kSecondSun, kRed, kBlue, kCovered };

/// A plant stands before a dark, a leaf-coloured and a white ground, of luminance 0, 0.3 and 1. The mean squared error over the three is
/// that before their mean, plus their variance times the squared error of coverage.
constexpr float kMeanGround = 110.0f, kCoverage = 107.0f;
/// The root mean square difference between leaves and these grounds is about this: a pixel without its leaf is wrong by as much.
constexpr float kGroundDifference = 180.0f;

struct Renderer {
  const BakedPlant* plant = nullptr;
  std::vector<AlphaMask> masks;         ///< [material]
  std::vector<glm::vec3> card_albedo;   ///< [card] linear
  std::vector<Projection> projections;  ///< [kErrorViewCount]
  Color background{};                   ///< grey, as colourful as the leaves, so that coverage does not change that
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
  return {kMeanGround, kMeanGround, mean.x, mean.y, 0.0f};
}

Result<Renderer> make_renderer(const BakedPlant& plant) {
  Renderer renderer;
  renderer.plant = &plant;
  COPPICE_CHECK(move_into(renderer.masks, alpha_masks(plant.materials, plant.images)));
  const std::vector<glm::vec3> colors = mean_texel_colors(plant.materials, plant.images, renderer.masks);
  for (const Card& card : plant.card_table) renderer.card_albedo.push_back(colors[card.material]);
  renderer.background = background_of(plant, renderer.card_albedo);
  renderer.projections = error_projections(plant.sphere);
  return renderer;
}

/// An image while it is drawn: what opaque leaves show, and the translucent fragments in front of that.
struct Canvas {
  struct Fragment {
    std::uint32_t pixel = 0, depth = 0;
    std::uint32_t leaf = 0;  ///< index into translucent_leaves
  };
  struct Leaf {
    Color color{};
    float opacity = 1.0f;
  };
  ColorImage image;
  std::vector<std::uint32_t> depths;
  std::vector<Leaf> translucent_leaves;
  std::vector<Fragment> translucent;
};

Color color_of(const Renderer& renderer, std::uint32_t node, const Projection& projection) {
  const Tree& tree = renderer.plant->tree;
  const glm::vec3& albedo = renderer.card_albedo[tree.nodes[node].card];
  const ShadingNormals normals = shading_normals(tree.nodes[node].normals, node_quad(tree, node));
  const glm::vec3 to_viewer(projection.direction[0], projection.direction[1], projection.direction[2]);
  Color color{};
  float sum = 0.0f;
  for (std::size_t i = 0; i < suns().size(); ++i) {
    const float cosine = leaf_cosine(normals, suns()[i].to_light, to_viewer, suns()[i].translucency);
    color[kFirstSun + i] = lambert_luminance(luminance(albedo), cosine);
    sum += cosine;
  }
  const glm::vec2 of_color = chroma(albedo, sum / static_cast<float>(suns().size()));
  color[kRed] = of_color.x;
  color[kBlue] = of_color.y;
  color[kCovered] = kCoverage;
  return color;
}

template <class Visit>
void for_each_fragment_of(const Renderer& renderer, std::uint32_t node, const Projection& projection, Visit&& visit) {
  const BakedPlant& plant = *renderer.plant;
  const Card& card = plant.card_table[plant.tree.nodes[node].card];
  rasterise_leaf(
      project(projection, node_quad(plant.tree, node)), card, renderer.masks[card.material], kErrorImagePx,
      [&](const QuadFragment& f) { visit(static_cast<std::uint32_t>(f.y) * kErrorImagePx + static_cast<std::uint32_t>(f.x), f.depth); });
}

void draw_opaque(const Renderer& renderer, std::uint32_t node, const Projection& projection, Canvas& canvas) {
  const Color color = color_of(renderer, node, projection);
  for_each_fragment_of(renderer, node, projection, [&](std::uint32_t pixel, std::uint32_t depth) {
    if (depth >= canvas.depths[pixel]) return;
    canvas.depths[pixel] = depth;
    for (std::size_t channel = 0; channel < color.size(); ++channel) canvas.image[channel][pixel] = color[channel];
  });
}

/// Composites the translucent fragments over the image, the farthest first.
void composite(Canvas& canvas) {
  // Sorts by pixel with one counting sort, then each pixel's few by depth.
  std::vector<std::uint32_t> end(canvas.depths.size(), 0);
  for (const Canvas::Fragment& fragment : canvas.translucent) ++end[fragment.pixel];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Canvas::Fragment> sorted(canvas.translucent.size());
  std::vector<std::uint32_t> begin = end;
  for (const Canvas::Fragment& fragment : canvas.translucent) sorted[--begin[fragment.pixel]] = fragment;
  const auto is_behind = [](const Canvas::Fragment& a, const Canvas::Fragment& b) {
    return a.depth != b.depth ? a.depth > b.depth : a.leaf > b.leaf;
  };
  for (std::size_t pixel = 0; pixel < end.size(); ++pixel) {
    std::sort(sorted.begin() + begin[pixel], sorted.begin() + end[pixel], is_behind);
    for (std::uint32_t i = begin[pixel]; i < end[pixel]; ++i) {
      const Canvas::Leaf& leaf = canvas.translucent_leaves[sorted[i].leaf];
      for (std::size_t channel = 0; channel < leaf.color.size(); ++channel)
        canvas.image[channel][pixel] += leaf.opacity * (leaf.color[channel] - canvas.image[channel][pixel]);
    }
  }
}

/// Renders the mean of many frames, each of which shows the share of a leaf's pixels that is its opacity.
ColorImage render(const Renderer& renderer, std::span<const std::uint32_t> nodes, const Projection& projection) {
  const Tree& tree = renderer.plant->tree;
  Canvas canvas;
  canvas.depths.assign(std::size_t{kErrorImagePx} * kErrorImagePx, 0xffffffffu);
  for (std::size_t channel = 0; channel < canvas.image.size(); ++channel)
    canvas.image[channel].assign(canvas.depths.size(), renderer.background[channel]);
  for (const std::uint32_t node : nodes)
    if (tree.nodes[node].opacity == kOpaque) draw_opaque(renderer, node, projection, canvas);
  for (const std::uint32_t node : nodes) {
    const std::uint8_t opacity = tree.nodes[node].opacity;
    if (opacity == kOpaque) continue;
    const auto leaf = static_cast<std::uint32_t>(canvas.translucent_leaves.size());
    canvas.translucent_leaves.push_back({color_of(renderer, node, projection), static_cast<float>(opacity) / kOpaque});
    for_each_fragment_of(renderer, node, projection, [&](std::uint32_t pixel, std::uint32_t depth) {
      if (depth < canvas.depths[pixel]) canvas.translucent.push_back({pixel, depth, leaf});
    });
  }
  composite(canvas);
  return std::move(canvas.image);
}

/// Squared errors of luminance, the mean over suns and grounds, plus a third of those of the colour differences: about the mean of red,
/// green and blue. Scaled so that kGroundDifference counts as white for black.
SquaredErrors squared_color_errors(const ColorImage& source, const ColorImage& other) {
  constexpr double kScale = double{kWhiteLuminance} * kWhiteLuminance / (double{kGroundDifference} * kGroundDifference);
  constexpr std::array<double, 5> kWeights{0.5, 0.5, 1.0 / 3.0, 1.0 / 3.0, 1.0};
  SquaredErrors errors{};
  for (std::size_t channel = 0; channel < kWeights.size(); ++channel) {
    const SquaredErrors of_channel = squared_errors(source[channel], other[channel]);
    for (std::size_t size = 0; size < errors.size(); ++size) errors[size] += kScale * kWeights[channel] * of_channel[size];
  }
  return errors;
}

/// Mean of the image's covered channel, 0..1.
double coverage_of(const ColorImage& image) {
  const LuminanceImage& covered = image[kCovered];
  return std::accumulate(covered.begin(), covered.end(), 0.0) / (double{kCoverage} * static_cast<double>(covered.size()));
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
  ViewCoverage source_coverage{};
  parallel_for(std::size_t{kErrorViewCount}, [&](std::size_t view) {
    source[view] = render(renderer, source_nodes, renderer.projections[view]);
    source_coverage[view] = coverage_of(source[view]);
  });

  ErrorTable table;
  table.leaf_counts = measured_leaf_counts(plant.tree.leaf_count());
  table.sizes_px.assign(kErrorSizesPx.begin(), kErrorSizesPx.end());
  for (std::size_t level = 0; level < table.leaf_counts.size(); ++level) {
    progress(static_cast<double>(level) / static_cast<double>(table.leaf_counts.size()));
    const std::vector<std::uint32_t> nodes = cut_nodes(plant.tree, table.leaf_counts[level]);
    std::array<SquaredErrors, kErrorViewCount> errors{};
    ViewCoverage coverage{};
    parallel_for(std::size_t{kErrorViewCount}, [&](std::size_t view) {
      const ColorImage image = render(renderer, nodes, renderer.projections[view]);
      errors[view] = squared_color_errors(source[view], image);
      coverage[view] = coverage_of(image);
    });
    const double change = nodes.size() <= kFewLeaves ? changed_coverage(source_coverage, coverage) : 0.0;
    for (std::size_t size = 0; size < kErrorSizesPx.size(); ++size)
      table.error_px.push_back(std::max(error_px_of(errors, size), coverage_error_px(change, kErrorSizesPx[size])));
  }
  for (std::size_t i = table.error_px.size() - kErrorSizesPx.size(); i-- > 0;)
    table.error_px[i] = std::max(table.error_px[i], table.error_px[i + kErrorSizesPx.size()]);
  progress(1.0);
  return table;
}

}  // namespace coppice::bake
