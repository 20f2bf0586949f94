#include "looks_measure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "leaf_shade.h"
#include "srgb.h"

namespace coppice::test {
namespace {

constexpr std::uint32_t kBlockPx = 8;
constexpr float kPlantBlock = 0.25f;  // share of a block
constexpr float kColorOff = 0.06f * 255.0f;
constexpr double kWrongBlocks = 0.05, kCoverageOff = 0.06, kWrongRows = 0.1, kPieceOff = 0.05;
constexpr double kFew = 2.0;       ///< blocks, and rows, that may be wrong in any case: in a small picture one is more than the share above
constexpr double kMinRowPx = 0.5;  ///< rows that cover less are tips
// A pixel that shows the plant in fewer frames than two of sixteen connects nothing.
constexpr float kPlantPixel = 0.125f;

glm::vec3 light_of(const glm::vec4& texel) {
  glm::vec3 light;
  for (int channel = 0; channel < 3; ++channel) light[channel] = linear_from_srgb(texel[channel] / 255.0f);
  return light;
}

glm::vec4 block_mean(const MeanPicture& picture, std::uint32_t left, std::uint32_t top) {
  glm::vec4 sum(0.0f);
  float count = 0;
  for (std::uint32_t y = top; y < std::min(top + kBlockPx, picture.height_px); ++y)
    for (std::uint32_t x = left; x < std::min(left + kBlockPx, picture.width_px); ++x, ++count)
      sum += picture.texels[std::size_t{y} * picture.width_px + x];
  return sum / count;
}

bool is_color_off(const glm::vec4& a, const glm::vec4& b) {
  const glm::vec3 off = glm::abs(glm::vec3(a) - glm::vec3(b));
  return std::max(off.x, std::max(off.y, off.z)) > kColorOff;
}

/// What the rows cover, px.
std::vector<double> covered_px(const MeanPicture& picture) {
  std::vector<double> rows(picture.height_px, 0.0);
  for (std::size_t i = 0; i < picture.texels.size(); ++i) rows[i / picture.width_px] += static_cast<double>(picture.texels[i].a);
  return rows;
}

double wrong_rows(const std::vector<double>& expected_px, const std::vector<double>& found_px) {
  double rows = 0, wrong = 0;
  for (std::size_t y = 0; y < expected_px.size(); ++y) {
    if (expected_px[y] < kMinRowPx) continue;
    ++rows;
    wrong += found_px[y] < 0.5 * expected_px[y] || found_px[y] > 2.0 * expected_px[y];
  }
  return rows > 0 ? std::max(wrong - kFew, 0.0) / rows : 0;
}

/// Takes the piece that holds pixel `first` out of `left`; what it covers, px.
double take_piece(const MeanPicture& picture, std::vector<bool>& left, std::size_t first) {
  std::vector<std::size_t> open{first};
  left[first] = false;
  double covered = 0;
  const auto width = static_cast<std::int64_t>(picture.width_px), height = static_cast<std::int64_t>(picture.height_px);
  while (!open.empty()) {
    const std::size_t at = open.back();
    open.pop_back();
    covered += static_cast<double>(picture.texels[at].a);
    const std::int64_t x = static_cast<std::int64_t>(at) % width, y = static_cast<std::int64_t>(at) / width;
    for (std::int64_t j = std::max<std::int64_t>(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
      for (std::int64_t i = std::max<std::int64_t>(x - 1, 0); i <= std::min(x + 1, width - 1); ++i) {
        const auto next = static_cast<std::size_t>(j * width + i);
        if (!left[next]) continue;
        left[next] = false;
        open.push_back(next);
      }
  }
  return covered;
}

double largest_piece(const MeanPicture& picture) {
  std::vector<bool> left(picture.texels.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = picture.texels[i].a >= kPlantPixel;
  double largest = 0, all = 0;
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (!left[i]) continue;
    const double piece = take_piece(picture, left, i);
    largest = std::max(largest, piece);
    all += piece;
  }
  return all > 0 ? largest / all : 0;
}

}  // namespace

glm::vec3 displayed(const glm::vec3& light) {
  glm::vec3 color;
  for (int channel = 0; channel < 3; ++channel) color[channel] = 255.0f * srgb_from_linear(std::max(light[channel], 0.0f));
  return color;
}

glm::vec3 mean_color(const MeanPicture& picture) {
  glm::vec3 sum(0.0f);
  float covered = 0;
  const glm::vec3 background = light_of(picture.texels.front());
  for (const glm::vec4& texel : picture.texels) {
    sum += light_of(texel) - (1.0f - texel.a) * background;
    covered += texel.a;
  }
  return displayed(covered > 0 ? sum / covered : sum);
}

double rmse_on(const MeanPicture& reference, const MeanPicture& picture, const glm::vec3& background) {
  const glm::vec3 other = light_of(glm::vec4(background, 1)) - light_of(reference.texels.front());
  const auto shown = [&](const glm::vec4& texel) { return displayed(light_of(texel) + (1.0f - texel.a) * other); };
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < reference.texels.size(); ++i) {
    if (reference.texels[i].a == 0 && picture.texels[i].a == 0) continue;
    const double off = static_cast<double>(bake::luminance(shown(picture.texels[i]) - shown(reference.texels[i])));
    sum += off * off;
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

LooksDifference compare_looks(const MeanPicture& reference, const MeanPicture& picture) {
  if (reference.width_px != picture.width_px || reference.height_px != picture.height_px)
    throw std::runtime_error("pictures of different sizes");
  LooksDifference result;
  std::uint32_t wrong = 0;
  for (std::uint32_t y = 0; y < reference.height_px; y += kBlockPx)
    for (std::uint32_t x = 0; x < reference.width_px; x += kBlockPx) {
      const glm::vec4 expected = block_mean(reference, x, y);
      if (expected.a < kPlantBlock) continue;
      ++result.blocks;
      wrong += is_color_off(expected, block_mean(picture, x, y));
    }
  if (result.blocks > 0) result.wrong_blocks = static_cast<double>(wrong) / result.blocks;
  const std::vector<double> expected_px = covered_px(reference), found_px = covered_px(picture);
  const double sum_px = std::accumulate(expected_px.begin(), expected_px.end(), 0.0);
  if (sum_px == 0.0) throw std::runtime_error("the reference shows no plant");
  result.coverage = std::accumulate(found_px.begin(), found_px.end(), 0.0) / sum_px;
  result.wrong_rows = wrong_rows(expected_px, found_px);
  result.largest_piece = largest_piece(picture);
  result.reference_largest_piece = largest_piece(reference);
  return result;
}

bool looks_alike(const LooksDifference& difference) {
  const double coverage_off = std::round(1000.0 * std::abs(difference.coverage - 1.0)) / 1000.0;  // as it is printed
  const double max_wrong = std::max(kWrongBlocks, difference.blocks > 0 ? kFew / difference.blocks : 0.0);
  return difference.wrong_blocks <= max_wrong && coverage_off <= kCoverageOff && difference.wrong_rows <= kWrongRows &&
         std::abs(difference.largest_piece - difference.reference_largest_piece) <= kPieceOff;
}

std::string describe(const LooksDifference& difference) {
  char line[192];
  std::snprintf(line, sizeof line,
                "%.1f %% of %u blocks and %.1f %% of the rows wrong, %.1f %% of the cover, largest piece %.1f %% instead of %.1f %%",
                100.0 * difference.wrong_blocks, difference.blocks, 100.0 * difference.wrong_rows, 100.0 * difference.coverage,
                100.0 * difference.largest_piece, 100.0 * difference.reference_largest_piece);
  return line;
}

Picture side_by_side(const MeanPicture& reference, const MeanPicture& picture) {
  constexpr std::uint32_t kMinPx = 256;
  constexpr float kStrength = 4.0f;
  const std::uint32_t scale = std::max(kMinPx / std::max(reference.width_px, 1u), 1u);
  const std::uint32_t panel_px = scale * reference.width_px;
  Picture result{3 * panel_px, scale * reference.height_px, {}};
  result.rgba.reserve(std::size_t{4} * result.width_px * result.height_px);
  for (std::uint32_t y = 0; y < result.height_px; ++y)
    for (std::uint32_t x = 0; x < result.width_px; ++x) {
      const std::size_t at = std::size_t{y / scale} * reference.width_px + x % panel_px / scale;
      const glm::vec3 expected(reference.texels[at]), found(picture.texels[at]);
      const std::uint32_t panel = x / panel_px;
      const glm::vec3 shown = panel == 0 ? expected : panel == 1 ? found : 127.5f + kStrength * (found - expected);
      for (int channel = 0; channel < 3; ++channel)
        result.rgba.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(shown[channel], 0.0f, 255.0f))));
      result.rgba.push_back(255);
    }
  return result;
}

}  // namespace coppice::test
