#include "texture_mips.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "alpha_mask.h"
#include "coppice/format.h"
#include "srgb.h"

namespace coppice::bake {

namespace {

std::uint8_t byte_from_unit(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

/// Sums over texels; divided by their weights they are a texel's colour and alpha.
struct WeighedTexel {
  glm::vec3 color{0.0f};  ///< linear, times color_weight
  float color_weight = 0.0f;
  float alpha = 0.0f;  ///< times shown
  float shown = 0.0f;
  float count = 1.0f;  ///< how many of level 0's texels

  void add(const WeighedTexel& other) {
    color += other.color;
    color_weight += other.color_weight;
    alpha += other.alpha;
    shown += other.shown;
    count += other.count;
  }
};

struct WeighedImage {
  std::uint32_t width = 0, height = 0;
  std::vector<WeighedTexel> texels;
};

/// A weight of colours besides the area that shows them. An image may have no texel that passes the alpha test, or be all clear.
enum class ColorWeight : std::uint8_t { passes_test, alpha, one };

WeighedImage weighed(const Image& image, float alpha_cutoff, ColorWeight by) {
  WeighedImage result{image.width, image.height, {}};
  result.texels.reserve(std::size_t{image.width} * image.height);
  for (std::size_t i = 0; i + 3 < image.rgba.size(); i += 4) {
    const std::uint8_t* rgba = image.rgba.data() + i;
    const float shown = image.shown.empty() ? 1.0f : image.shown[i / 4], alpha = static_cast<float>(rgba[3]) / 255.0f;
    const float seen = by == ColorWeight::one ? 1.0f : by == ColorWeight::alpha ? alpha : is_solid(rgba[3], alpha_cutoff) ? 1.0f : 0.0f;
    result.texels.push_back({shown * seen * linear_color(rgba), shown * seen, shown * alpha, shown});
  }
  return result;
}

WeighedImage halved(const WeighedImage& image) {
  WeighedImage result{std::max(1u, image.width / 2), std::max(1u, image.height / 2), {}};
  result.texels.resize(std::size_t{result.width} * result.height);
  for (std::uint32_t y = 0; y < result.height; ++y)
    for (std::uint32_t x = 0; x < result.width; ++x) {
      const MipFootprint columns = mip_footprint(x, image.width), rows = mip_footprint(y, image.height);
      WeighedTexel& sum = result.texels[std::size_t{y} * result.width + x];
      sum.count = 0.0f;
      for (std::uint32_t row = rows.first; row < rows.last; ++row)
        for (std::uint32_t column = columns.first; column < columns.last; ++column)
          sum.add(image.texels[std::size_t{row} * image.width + column]);
    }
  return result;
}

std::vector<WeighedImage> weighed_levels(const Image& image, float alpha_cutoff) {
  std::vector<WeighedImage> levels;
  for (const ColorWeight by : {ColorWeight::passes_test, ColorWeight::alpha, ColorWeight::one}) {
    levels.assign(1, weighed(image, alpha_cutoff, by));
    while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halved(levels.back()));
    if (levels.back().texels.front().color_weight > 0.0f) break;
  }
  return levels;
}

/// The texel of the coarser level above one of this.
const WeighedTexel& texel_above(const WeighedImage& coarser, std::uint32_t x, std::uint32_t y) {
  return coarser.texels[std::size_t{std::min(y / 2, coarser.height - 1)} * coarser.width + std::min(x / 2, coarser.width - 1)];
}

/// Divides sums by their weights. Where a weight is 0 it takes the texel above, which has been resolved already.
void resolve(WeighedImage& image, const WeighedImage* coarser) {
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      WeighedTexel& texel = image.texels[std::size_t{y} * image.width + x];
      if (texel.color_weight > 0.0f)
        texel.color /= texel.color_weight;
      else if (coarser != nullptr)
        texel.color = texel_above(*coarser, x, y).color;
      if (texel.shown > 0.0f)
        texel.alpha /= texel.shown;
      else if (coarser != nullptr)
        texel.alpha = texel_above(*coarser, x, y).alpha;
    }
}

Image quantised(const WeighedImage& image) {
  Image result{image.width, image.height, {}};
  result.rgba.reserve(image.texels.size() * 4);
  result.shown.reserve(image.texels.size());
  for (const WeighedTexel& texel : image.texels) {
    for (int channel = 0; channel < 3; ++channel) result.rgba.push_back(byte_from_unit(srgb_from_linear(texel.color[channel])));
    result.rgba.push_back(byte_from_unit(texel.alpha));
    result.shown.push_back(texel.shown / texel.count);
  }
  return result;
}

/// How much of the image is shown, by alpha.
using AlphaHistogram = std::array<double, 256>;

AlphaHistogram alpha_histogram(const Image& image) {
  AlphaHistogram histogram{};
  for (std::size_t i = 0; i * 4 < image.rgba.size(); ++i)
    histogram[image.rgba[4 * i + 3]] += image.shown.empty() ? 1.0 : static_cast<double>(image.shown[i]);
  return histogram;
}

double coverage_scaled(const AlphaHistogram& histogram, float scale, float alpha_cutoff) {
  double solid = 0.0, all = 0.0;
  for (std::size_t alpha = 0; alpha < histogram.size(); ++alpha) {
    all += histogram[alpha];
    if (is_solid(byte_from_unit(static_cast<float>(alpha) / 255.0f * scale), alpha_cutoff)) solid += histogram[alpha];
  }
  return all > 0.0 ? solid / all : 0.0;
}

/// Scales alpha so that coverage comes nearest to `target`, but never to 0: a leaf that thickens a little in its last levels is better than
/// one that vanishes. Coverage changes only where an alpha crosses the cutoff, so it suffices to test the scales that just carry each of
/// the 255 values over it.
void preserve_coverage(Image& image, float alpha_cutoff, double target) {
  const AlphaHistogram histogram = alpha_histogram(image);
  float best_scale = 1.0f;
  const auto distance = [&](float scale) {
    const double coverage = coverage_scaled(histogram, scale, alpha_cutoff);
    return coverage > 0.0 || target == 0.0 ? std::abs(coverage - target) : 2.0;
  };
  double best = distance(1.0f);
  for (std::uint32_t alpha = 255; alpha > 0; --alpha) {
    const float scale = alpha_cutoff * 255.0f / (static_cast<float>(alpha) - 0.25f);
    const double difference = distance(scale);
    if (difference < best) {
      best = difference;
      best_scale = scale;
    }
  }
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    image.rgba[i] = byte_from_unit(static_cast<float>(image.rgba[i]) / 255.0f * best_scale);
}

}  // namespace

MipFootprint mip_footprint(std::uint32_t index, std::uint32_t size) {
  const std::uint32_t half = std::max(1u, size / 2);
  return {std::min(2 * index, size - 1), index + 1 == half ? size : 2 * index + 2};
}

bool is_solid(std::uint8_t alpha, float alpha_cutoff) {
  return static_cast<float>(alpha) / 255.0f >= alpha_cutoff;
}

double alpha_coverage(const Image& image, float alpha_cutoff) {
  return coverage_scaled(alpha_histogram(image), 1.0f, alpha_cutoff);
}

std::vector<Image> mip_levels(const Image& image, float alpha_cutoff) {
  std::vector<WeighedImage> levels = weighed_levels(image, alpha_cutoff);
  for (std::size_t level = levels.size(); level-- > 0;) resolve(levels[level], level + 1 < levels.size() ? &levels[level + 1] : nullptr);
  const double target = alpha_coverage(image, alpha_cutoff);
  std::vector<Image> result;
  for (const WeighedImage& level : levels) {
    if (level.width > COPPICE_MAX_TEXTURE_SIDE || level.height > COPPICE_MAX_TEXTURE_SIDE) continue;
    result.push_back(quantised(level));
    if (alpha_cutoff > 0.0f && &level != &levels.front()) preserve_coverage(result.back(), alpha_cutoff, target);
  }
  return result;
}

}  // namespace coppice::bake
