#include "texture_shown.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/common.hpp>

#include "alpha_mask.h"
#include "srgb.h"

namespace coppice::bake {
namespace {

/// Samples on each side of a triangle's grid.
constexpr int kGrid = 6;
/// Units of all the area that shows an image: a texel of 2^24 with a millionth of its part still counts.
constexpr double kUnits = 4503599627370496.0;  // 2^52
/// Units of a texel's coverage, and the minimum that counts: sampling lines miss a texel's edge by a little.
constexpr double kCoverageUnits = 1048576.0;
constexpr double kMinCoverage = 1.0 / 16.0;
/// A triangle that repeats the image more often than this counts as showing all texels alike.
constexpr double kMaxPeriods = 64.0;
/// Sampling lines to a row of texels, and to a triangle; a row has at least one.
constexpr std::int64_t kLinesPerRow = 4, kMaxLines = 4096;
constexpr int kPointsOnLine = 64;

std::int64_t units(double share) {
  return share > 0.0 ? std::max<std::int64_t>(std::llround(share * kUnits), 1) : 0;
}

std::int64_t wrapped(std::int64_t value, std::int64_t side) {
  return (value % side + side) % side;
}

/// Where a line of constant y crosses the triangle; first > last where it does not.
std::array<double, 2> crossing(const std::array<glm::dvec2, 3>& points, double y) {
  std::array<double, 2> span{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec2 &a = points[k], &b = points[(k + 1) % 3];
    if ((a.y <= y) == (b.y <= y)) continue;
    const double x = a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y);
    span = {std::min(span[0], x), std::max(span[1], x)};
  }
  return span;
}

/// Counts triangles with the same texture coordinates once, with the sum of their areas: many leaves are copies.
struct AreaOfUvs {
  std::array<float, 6> uvs{};
  double area_m2 = 0.0;
};

std::vector<AreaOfUvs> merge_equal(std::vector<AreaOfUvs> triangles) {
  std::ranges::stable_sort(triangles, {}, &AreaOfUvs::uvs);
  std::vector<AreaOfUvs> merged;
  for (const AreaOfUvs& each : triangles) {
    if (merged.empty() || merged.back().uvs != each.uvs)
      merged.push_back(each);
    else
      merged.back().area_m2 += each.area_m2;
  }
  return merged;
}

}  // namespace

double color_difference(const glm::dvec3& a, const glm::dvec3& b) {
  double largest = 0.0;
  for (int c = 0; c < 3; ++c) {
    const float difference = srgb_from_linear(static_cast<float>(a[c])) - srgb_from_linear(static_cast<float>(b[c]));
    largest = std::max(largest, static_cast<double>(std::abs(difference)));
  }
  return largest;
}

ColorSum triangle_color(const Material& material, const std::vector<Image>& images, const UvTriangle& uvs, double area_m2) {
  if (material.image == kNone) return {glm::dvec3(area_m2), area_m2};
  const Image& image = images[material.image];
  glm::dvec3 sum(0.0);
  int solid = 0, all = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j + i < kGrid; ++j, ++all) {
      const double s = (i + 1.0 / 3.0) / kGrid, t = (j + 1.0 / 3.0) / kGrid;
      const glm::dvec2 uv = (1.0 - s - t) * glm::dvec2(uvs[0]) + s * glm::dvec2(uvs[1]) + t * glm::dvec2(uvs[2]);
      const std::uint8_t* const texel = texel_at(image, uv);
      if (static_cast<float>(texel[3]) < material.alpha_cutoff * 255.0f) continue;
      sum += glm::dvec3(linear_color(texel));
      ++solid;
    }
  return {area_m2 / all * sum, area_m2 * solid / all};
}

void ShownArea::add(const UvTriangle& uvs, double share) {
  std::array<glm::dvec2, 3> points{};
  for (std::size_t k = 0; k < 3; ++k) points[k] = glm::dvec2(uvs[k]) * glm::dvec2(side_);
  const glm::dvec2 low = glm::min(glm::min(points[0], points[1]), points[2]);
  const glm::dvec2 high = glm::max(glm::max(points[0], points[1]), points[2]);
  const glm::dvec2 periods = (high - low) / glm::dvec2(side_);
  constexpr double kFar = 1e9;  // texels; beyond that floats are too coarse for coordinates
  if (!(periods.x < kMaxPeriods && periods.y < kMaxPeriods && glm::length(low) < kFar && glm::length(high) < kFar))
    return add_everywhere(share);
  const glm::dvec2 ab = points[1] - points[0], ac = points[2] - points[0];
  const double area = 0.5 * std::abs(ab.x * ac.y - ab.y * ac.x);
  const auto first_row = static_cast<std::int64_t>(std::floor(low.y)), last_row = static_cast<std::int64_t>(std::ceil(high.y));
  const std::int64_t lines = std::clamp<std::int64_t>(kMaxLines / std::max<std::int64_t>(last_row - first_row, 1), 1, kLinesPerRow);
  bool found = false;
  for (std::int64_t row = first_row; row < last_row && area > 1e-6; ++row)
    for (std::int64_t line = 0; line < lines; ++line) {
      const double per_row = 1.0 / static_cast<double>(lines);
      const auto [first, last] = crossing(points, static_cast<double>(row) + (static_cast<double>(line) + 0.5) * per_row);
      if (!(first < last)) continue;
      add_span(row, first, last, {share / area * per_row, per_row});
      found = true;
    }
  if (!found) add_line(points, share);
}

std::vector<float> ShownArea::weights() const {
  std::vector<std::int64_t> sums;
  sums.reserve(std::size_t{side_.x} * side_.y);
  std::int64_t largest = 1;
  for (std::size_t y = 0; y < side_.y; ++y) {
    Step sum;
    for (std::size_t x = 0; x < side_.x; ++x) {
      const Step& step = steps_[y * (side_.x + 1) + x];
      sum.area += step.area;
      sum.coverage += step.coverage;
      const bool is_shown = static_cast<double>(sum.coverage) >= kMinCoverage * kCoverageUnits;
      sums.push_back(is_shown ? sum.area : 0);
      largest = std::max(largest, sums.back());
    }
  }
  std::vector<float> result;
  result.reserve(sums.size());
  for (const std::int64_t sum : sums) result.push_back(static_cast<float>(static_cast<double>(sum) / static_cast<double>(largest)));
  return result;
}

void ShownArea::add_everywhere(double share) {
  const double density = share / (static_cast<double>(side_.x) * side_.y);
  for (std::size_t y = 0; y < side_.y; ++y) add_within(y, 0.0, side_.x, {density, 1.0});
}

/// Adds a triangle without area in the image: a palette's colours are often a point or a line.
void ShownArea::add_line(const std::array<glm::dvec2, 3>& points, double share) {
  std::size_t longest = 0;
  const auto edge = [&](std::size_t k) { return points[(k + 1) % 3] - points[k]; };
  for (std::size_t k = 1; k < 3; ++k)
    if (glm::length(edge(k)) > glm::length(edge(longest))) longest = k;
  for (int i = 0; i < kPointsOnLine; ++i) {
    const glm::dvec2 at = glm::floor(points[longest] + (i + 0.5) / kPointsOnLine * edge(longest));
    add_span(static_cast<std::int64_t>(at.y), at.x, at.x + 1.0, {share / kPointsOnLine, 1.0});
  }
}

void ShownArea::add_span(std::int64_t row, double first, double last, const Density& density) {
  const double side = side_.x;
  const auto y = static_cast<std::size_t>(wrapped(row, side_.y));
  const double whole = std::floor((last - first) / side);
  if (whole > 0.0) add_within(y, 0.0, side, {density.area * whole, density.coverage});
  const double period = std::floor(first / side) * side;
  const double from = first - period, to = last - whole * side - period;
  add_within(y, from, std::min(to, side), density);
  if (to > side) add_within(y, 0.0, to - side, density);
}

/// Adds a span within the image: 0 <= first, last <= side.
void ShownArea::add_within(std::size_t row, double first, double last, const Density& density) {
  if (!(first < last)) return;
  Step* steps = steps_.data() + row * (side_.x + 1);
  const auto add_texels = [&](std::size_t from, std::size_t to, double part) {
    const std::int64_t area = units(density.area * part), coverage = std::llround(density.coverage * part * kCoverageUnits);
    steps[from].area += area;
    steps[from].coverage += coverage;
    steps[to].area -= area;
    steps[to].coverage -= coverage;
  };
  const auto left = std::min(static_cast<std::size_t>(first), std::size_t{side_.x} - 1);
  const auto right = std::min(static_cast<std::size_t>(last), std::size_t{side_.x} - 1);
  if (left == right) return add_texels(left, left + 1, last - first);
  add_texels(left, left + 1, static_cast<double>(left + 1) - first);
  if (left + 1 < right) add_texels(left + 1, right, 1.0);
  add_texels(right, right + 1, last - static_cast<double>(right));
}

void measure_shown_texels(Plant& plant) {
  std::vector<std::vector<AreaOfUvs>> triangles(plant.images.size());
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for (std::size_t t = 0; t < mesh->triangle_materials.size(); ++t) {
      const std::uint32_t image = plant.materials[mesh->triangle_materials[t]].image;
      if (image == kNone) continue;
      const UvTriangle uvs = triangle_uvs(*mesh, t);
      triangles[image].push_back({{uvs[0].x, uvs[0].y, uvs[1].x, uvs[1].y, uvs[2].x, uvs[2].y}, triangle_area_m2(*mesh, t)});
    }
  for (std::size_t i = 0; i < plant.images.size(); ++i) {
    const std::vector<AreaOfUvs> merged = merge_equal(std::move(triangles[i]));
    double area_m2 = 0.0;
    for (const AreaOfUvs& each : merged) area_m2 += each.area_m2;
    if (!(area_m2 > 0.0)) continue;
    ShownArea shown({plant.images[i].width, plant.images[i].height});
    for (const auto& [uvs, each_m2] : merged)
      shown.add({glm::vec2(uvs[0], uvs[1]), glm::vec2(uvs[2], uvs[3]), glm::vec2(uvs[4], uvs[5])}, each_m2 / area_m2);
    std::vector<float> weights = shown.weights();
    if (std::ranges::any_of(weights, [](float weight) { return weight > 0.0f; })) plant.images[i].shown = std::move(weights);
  }
}

}  // namespace coppice::bake
