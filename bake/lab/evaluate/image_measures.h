#pragma once

// How one picture differs from another: sums over pixels that add up over cameras.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluation_render.h"

namespace coppice::bake {

/// Mean of each factor x factor block. values [size_px^2]; factor divides size_px (asserted). returns [(size_px / factor)^2]
std::vector<float> box_filtered(std::span<const float> values, std::uint32_t size_px, std::uint32_t factor);

/// Sums of one or more pairs of pictures. Pictures are as rendered, and box-filtered by 4 and by 16 both ways: what a viewer four and
/// sixteen times as far away sees.
struct ImageSums {
  static constexpr std::array<std::uint32_t, 3> kFactors = {1, 4, 16};
  static constexpr std::uint32_t kIouFactor = 4;

  std::array<double, 3> squared_errors{};   ///< luminance differences squared, by kFactors
  std::array<std::uint64_t, 3> pixels{};    ///< compared, by kFactors
  std::uint64_t covered = 0;                ///< pixels in which the picture shows foliage
  std::uint64_t reference_covered = 0;      ///< and the reference
  double intersection = 0.0, united = 0.0;  ///< sums of the lesser and of the greater of both pictures' coverage, filtered by kIouFactor

  void add(const ImageSums& other);
  /// sqrt(mean squared error) by kFactors; 0..255
  [[nodiscard]] double rmse(std::size_t factor_index) const;
  /// Foliage pixels over the reference's; 1 when both have none, infinite when only the reference has none.
  [[nodiscard]] double coverage_ratio() const;
  /// Intersection over union of fractional coverage; 1 when both pictures are empty.
  [[nodiscard]] double soft_iou() const;
};

/// Errors alone, without coverage. [size_px^2] each (asserted); size_px a multiple of 16 (asserted)
ImageSums compare_luminance(std::span<const float> image, std::span<const float> reference, std::uint32_t size_px);

/// Both of the same size, a multiple of 16 (asserted).
ImageSums compare_images(const EvaluationImage& image, const EvaluationImage& reference);

}  // namespace coppice::bake
