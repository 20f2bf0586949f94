#include "error_image.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <glm/geometric.hpp>

#include "leaf_shade.h"

namespace coppice::bake {
namespace {

/// Applies a 2 x 2 box filter.
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

}  // namespace

std::vector<Viewpoint> error_viewpoints() {
  const glm::vec3 axis = glm::normalize(glm::vec3(0.36f, 0.48f, 0.80f));
  constexpr float kCosine = 0.64f, kSine = 0.768375f;  // about 50 degrees
  std::vector<Viewpoint> views;
  for (const Viewpoint& view : *viewpoints(kErrorViewCount)) {
    const glm::vec3& d = view.direction;
    const glm::vec3 turned = d * kCosine + glm::cross(axis, d) * kSine + axis * (glm::dot(axis, d) * (1.0f - kCosine));
    views.push_back(viewpoint_towards(glm::normalize(turned)));
  }
  return views;
}

std::vector<Projection> error_projections(const Sphere& sphere) {
  std::vector<Projection> projections;
  for (const Viewpoint& view : error_viewpoints()) projections.push_back(make_projection(view, sphere, kErrorImagePx));
  return projections;
}

const glm::vec3& error_light() {
  static const glm::vec3 direction = glm::normalize(glm::vec3(0.4f, 0.8f, 0.45f));
  return direction;
}

float plant_luminance(float luminance) {
  constexpr float kBright = 0.5f * kWhiteLuminance;
  return luminance <= kBright ? luminance : 0.5f * (luminance + kBright);
}

LuminanceImage coarse_image(LuminanceImage image, std::uint32_t from_px, std::uint32_t size_px) {
  for (; from_px > size_px; from_px /= 2) image = halve(image, from_px);
  return image;
}

SquaredErrors squared_errors(const LuminanceImage& source, const LuminanceImage& other) {
  // Box filtering is linear: the difference of filtered images is the filtered difference.
  LuminanceImage difference(source.size());
  std::ranges::transform(source, other, difference.begin(), std::minus<>());
  SquaredErrors errors{};
  for (std::size_t size = kErrorSizesPx.size(); size-- > 0;) {
    errors[size] = mean_square(difference);
    if (size > 0) difference = halve(difference, kErrorSizesPx[size]);
  }
  return errors;
}

float error_px_of(const std::array<SquaredErrors, kErrorViewCount>& errors, std::size_t size) {
  double sum = 0.0;
  for (const SquaredErrors& view_errors : errors) sum += view_errors[size];
  return static_cast<float>(kErrorSizesPx[size] * std::sqrt(sum / kErrorViewCount) / kWhiteLuminance);
}

double changed_coverage(const ViewCoverage& source, const ViewCoverage& other) {
  double changed = 0.0, covered = 0.0;
  for (std::size_t view = 0; view < source.size(); ++view) {
    changed += std::abs(other[view] - source[view]);
    covered += source[view];
  }
  return covered > 0.0 ? changed / covered : 0.0;
}

float coverage_error_px(double share, std::uint32_t size_px) {
  constexpr double kErrorPerShare_px = 40.0, kSmall_px = 16.0;
  const double small = std::min(size_px / kSmall_px, 1.0);
  return static_cast<float>(kErrorPerShare_px * small * small * share);
}

}  // namespace coppice::bake
