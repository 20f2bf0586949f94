#pragma once

// How one image differs from another, as sums over pixels, which add up over cameras.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluation_render.h"

namespace coppice::bake {

/// Averages each factor x factor block. values  [size_px^2]; factor divides size_px (asserted). returns  [(size_px / factor)^2]
std::vector<float> box_filtered(std::span<const float> values, std::uint32_t size_px, std::uint32_t factor);

/// Sums of one or more pairs of images, as rendered and box-filtered by 4 and by 16 both ways: what a viewer at four and sixteen times the
/// distance sees.
struct ImageSums {
  static constexpr std::array<std::uint32_t, 3> kFactors = {1, 4, 16};
  static constexpr std::uint32_t kIouFactor = 4;

  std::array<double, 3> squared_errors{};   ///< [kFactors] squared differences of luminance
  std::array<std::uint64_t, 3> pixels{};    ///< [kFactors] how many were compared
  std::uint64_t covered = 0;                ///< pixels in which the image shows foliage
  std::uint64_t reference_covered = 0;      ///< pixels in which the reference does
  double intersection = 0.0, united = 0.0;  ///< sums of the minimum and of the maximum of both images' coverage, filtered by kIouFactor

  void add(const ImageSums& other);
  /// sqrt(mean squared error), 0..255. factor_index  into kFactors
  [[nodiscard]] double rmse(std::size_t factor_index) const;
  /// Foliage pixels over the reference's; 1 if both have none, infinite if only the reference has none.
  [[nodiscard]] double coverage_ratio() const;
  /// Intersection over union of fractional coverage; 1 if both images are empty.
  [[nodiscard]] double soft_iou() const;
};

/// Computes errors only, without coverage. [size_px^2] each (asserted); size_px a multiple of 16 (asserted)
ImageSums compare_luminance(std::span<const float> image, std::span<const float> reference, std::uint32_t size_px);

/// Compares two images of the same size, a multiple of 16 (asserted).
ImageSums compare_images(const EvaluationImage& image, const EvaluationImage& reference);

}  // namespace coppice::bake
