#include "texture_mips.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "coppice/format.h"
#include "srgb.h"

namespace coppice::bake {

namespace {

std::uint8_t byte_from_unit(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

/// Linear colour times alpha, and alpha, per texel.
struct FloatImage {
  std::uint32_t width = 0, height = 0;
  std::vector<glm::vec4> texels;
};

FloatImage premultiplied(const Image& image) {
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
  FloatImage result{image.width, image.height, {}};
  result.texels.reserve(std::size_t{image.width} * image.height);
  for (std::size_t i = 0; i + 3 < image.rgba.size(); i += 4) {
    const float alpha = static_cast<float>(image.rgba[i + 3]) / 255.0f;
    const glm::vec3 colour(linear[image.rgba[i]], linear[image.rgba[i + 1]], linear[image.rgba[i + 2]]);
    result.texels.emplace_back(colour * alpha, alpha);
  }
  return result;
}

FloatImage halved(const FloatImage& image) {
  FloatImage result{std::max(1u, image.width / 2), std::max(1u, image.height / 2), {}};
  for (std::uint32_t y = 0; y < result.height; ++y)
    for (std::uint32_t x = 0; x < result.width; ++x) {
      const MipFootprint columns = mip_footprint(x, image.width), rows = mip_footprint(y, image.height);
      glm::vec4 sum(0.0f);
      for (std::uint32_t row = rows.first; row < rows.last; ++row)
        for (std::uint32_t column = columns.first; column < columns.last; ++column)
          sum += image.texels[std::size_t{row} * image.width + column];
      result.texels.push_back(sum / static_cast<float>((rows.last - rows.first) * (columns.last - columns.first)));
    }
  return result;
}

/// Divides by alpha; where that is 0, the colour of the texel above, whose own has been found already.
void unpremultiply(FloatImage& image, const FloatImage* coarser) {
  for (std::uint32_t y = 0; y < image.height; ++y)
    for (std::uint32_t x = 0; x < image.width; ++x) {
      glm::vec4& texel = image.texels[std::size_t{y} * image.width + x];
      if (texel.w > 0.0f) {
        texel = glm::vec4(texel.x / texel.w, texel.y / texel.w, texel.z / texel.w, texel.w);
      } else if (coarser != nullptr) {
        const std::uint32_t above_x = std::min(x / 2, coarser->width - 1), above_y = std::min(y / 2, coarser->height - 1);
        const glm::vec4& above = coarser->texels[std::size_t{above_y} * coarser->width + above_x];
        texel = glm::vec4(above.x, above.y, above.z, 0.0f);
      }
    }
}

Image quantised(const FloatImage& image) {
  Image result{image.width, image.height, {}};
  result.rgba.reserve(image.texels.size() * 4);
  for (const glm::vec4& texel : image.texels) {
    for (int channel = 0; channel < 3; ++channel) result.rgba.push_back(byte_from_unit(srgb_from_linear(texel[channel])));
    result.rgba.push_back(byte_from_unit(texel.w));
  }
  return result;
}

using AlphaHistogram = std::array<std::uint64_t, 256>;

double coverage_scaled(const AlphaHistogram& histogram, float scale, float alpha_cutoff) {
  std::uint64_t solid = 0, all = 0;
  for (std::size_t alpha = 0; alpha < histogram.size(); ++alpha) {
    all += histogram[alpha];
    if (is_solid(byte_from_unit(static_cast<float>(alpha) / 255.0f * scale), alpha_cutoff)) solid += histogram[alpha];
  }
  return static_cast<double>(solid) / static_cast<double>(all);
}

/// Scales alpha so that coverage comes nearest to `target`, but never to nothing: a leaf that thickens a little in its last levels is
/// better than one that vanishes. Coverage changes only where some alpha value crosses the cutoff, so the
/// scales that just carry each of the 255 values over it are all there is to try.
void preserve_coverage(Image& image, float alpha_cutoff, double target) {
  AlphaHistogram histogram{};
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) ++histogram[image.rgba[i]];
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
  AlphaHistogram histogram{};
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) ++histogram[image.rgba[i]];
  return coverage_scaled(histogram, 1.0f, alpha_cutoff);
}

std::vector<Image> mip_levels(const Image& image, float alpha_cutoff) {
  std::vector<FloatImage> levels = {premultiplied(image)};
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halved(levels.back()));
  for (std::size_t level = levels.size(); level-- > 0;)
    unpremultiply(levels[level], level + 1 < levels.size() ? &levels[level + 1] : nullptr);
  const double target = alpha_coverage(image, alpha_cutoff);
  std::vector<Image> result;
  for (const FloatImage& level : levels) {
    if (level.width > COPPICE_MAX_TEXTURE_SIDE || level.height > COPPICE_MAX_TEXTURE_SIDE) continue;
    result.push_back(quantised(level));
    if (alpha_cutoff > 0.0f && &level != &levels.front()) preserve_coverage(result.back(), alpha_cutoff, target);
  }
  return result;
}

}  // namespace coppice::bake
