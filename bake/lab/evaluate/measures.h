#pragma once

// How one image differs from another, as sums over pixels, which add up over cameras; and all figures of one level against the source, on
// images and on the surface.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluate.h"
#include "evaluation_render.h"
#include "level.h"
#include "level_files.h"
#include "surface_distance.h"

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

/// The surface that images and distances are compared with, and what it shows. Holds references.
struct ReferenceSurface {
  const Level& level;
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
  const StoredLevel* stored = nullptr;  ///< to be compared too
};

/// The source, with everything that each comparison needs.
struct Reference {
  std::uint32_t size_px = 0;
  bool suns_and_frames = false;
  Level level;
  std::vector<SurfaceLook> looks;
  std::vector<EvaluationCamera> cameras;
  std::vector<EvaluationImage> images;            ///< [camera]
  double mean_tone = 1.0;                         ///< see leaf_luminances
  std::vector<std::vector<float>> frame_means{};  ///< [camera] none unless suns_and_frames
  SurfaceSamples samples;
  TriangleTree tree;
  double area_m2 = 0.0, diagonal_m = 0.0;
};

/// Textured if images are compared with the plant as modelled; a mean colour if simplifiers are compared, by where they put leaves.
SurfaceColour reference_colour(ReferenceKind reference);

/// errors  invalid_argument: no leaves, or none with an area; those of surface_looks
Result<Reference> make_reference(const ReferenceSurface& surface, const EvaluateOptions& options);

/// Compares images of one frame under one sun.
ImageSums measure_images(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference);

/// Computes all figures but those about the method. sums  from measure_images of this level
LevelMeasures measure_level(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference, const ImageSums& sums);

}  // namespace coppice::bake
