#include "image_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "check.h"

namespace coppice::bake {

std::vector<float> box_filtered(std::span<const float> values, std::uint32_t size_px, std::uint32_t factor) {
  COPPICE_ASSERT(factor > 0 && size_px % factor == 0 && values.size() == std::size_t{size_px} * size_px);
  const std::uint32_t result_px = size_px / factor;
  std::vector<float> result;
  result.reserve(std::size_t{result_px} * result_px);
  for (std::size_t block_y = 0; block_y < result_px; ++block_y)
    for (std::size_t block_x = 0; block_x < result_px; ++block_x) {
      double sum = 0.0;
      for (std::size_t y = 0; y < factor; ++y)
        for (std::size_t x = 0; x < factor; ++x) sum += double{values[(block_y * factor + y) * size_px + block_x * factor + x]};
      result.push_back(static_cast<float>(sum / (double{static_cast<double>(factor)} * factor)));
    }
  return result;
}

void ImageSums::add(const ImageSums& other) {
  for (std::size_t i = 0; i < kFactors.size(); ++i) {
    squared_errors[i] += other.squared_errors[i];
    pixels[i] += other.pixels[i];
  }
  covered += other.covered;
  reference_covered += other.reference_covered;
  intersection += other.intersection;
  united += other.united;
}

double ImageSums::rmse(std::size_t factor_index) const {
  return pixels[factor_index] == 0 ? 0.0 : std::sqrt(squared_errors[factor_index] / static_cast<double>(pixels[factor_index]));
}

double ImageSums::coverage_ratio() const {
  if (reference_covered == 0) return covered == 0 ? 1.0 : std::numeric_limits<double>::infinity();
  return static_cast<double>(covered) / static_cast<double>(reference_covered);
}

double ImageSums::soft_iou() const {
  return united > 0.0 ? intersection / united : 1.0;
}

ImageSums compare_luminance(std::span<const float> image, std::span<const float> reference, std::uint32_t size_px) {
  COPPICE_ASSERT(image.size() == reference.size() && image.size() == std::size_t{size_px} * size_px);
  ImageSums sums;
  // Filtering is linear: the difference of filtered images is the filtered difference.
  std::vector<float> difference(image.size());
  std::ranges::transform(image, reference, difference.begin(), std::minus<>());
  for (std::size_t i = 0; i < ImageSums::kFactors.size(); ++i) {
    for (const float value : box_filtered(difference, size_px, ImageSums::kFactors[i])) {
      sums.squared_errors[i] += double{value} * double{value};
      ++sums.pixels[i];
    }
  }
  return sums;
}

ImageSums compare_images(const EvaluationImage& image, const EvaluationImage& reference) {
  COPPICE_ASSERT(image.size_px == reference.size_px);
  ImageSums sums = compare_luminance(image.luminance, reference.luminance, image.size_px);
  const std::vector<float> coverage(image.coverage.begin(), image.coverage.end());
  const std::vector<float> reference_coverage(reference.coverage.begin(), reference.coverage.end());
  for (const std::uint8_t covered : image.coverage) sums.covered += covered;
  for (const std::uint8_t covered : reference.coverage) sums.reference_covered += covered;
  const std::vector<float> soft = box_filtered(coverage, image.size_px, ImageSums::kIouFactor);
  const std::vector<float> reference_soft = box_filtered(reference_coverage, image.size_px, ImageSums::kIouFactor);
  for (std::size_t i = 0; i < soft.size(); ++i) {
    sums.intersection += double{std::min(soft[i], reference_soft[i])};
    sums.united += double{std::max(soft[i], reference_soft[i])};
  }
  return sums;
}

}  // namespace coppice::bake
