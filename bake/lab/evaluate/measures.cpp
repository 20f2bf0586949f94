#include "measures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "check.h"
#include "parallel_for.h"

namespace coppice::bake {
namespace {

constexpr std::uint32_t kSurfacePoints = 20000;

double box_diagonal_m(const Mesh& mesh) {
  glm::dvec3 low(mesh.positions.front()), high = low;
  for (const glm::vec3& position : mesh.positions) {
    low = glm::min(low, glm::dvec3(position));
    high = glm::max(high, glm::dvec3(position));
  }
  return glm::distance(low, high);
}

/// Adds up sums over cameras, in the cameras' order whatever the threads.
template <class Sums, class CameraSums>
Sums sum_over_cameras(const Reference& reference, const CameraSums& camera_sums) {
  std::vector<Sums> by_camera(reference.cameras.size());
  parallel_for(by_camera.size(), [&](std::size_t camera) { by_camera[camera] = camera_sums(camera); });
  Sums all;
  for (const Sums& sums : by_camera) all.add(sums);
  return all;
}

/// Sums under all lights, of one camera or of several.
struct LightSums {
  /// Luminance of pixels with foliage.
  struct Foliage {
    double luminance = 0.0;
    std::size_t pixel_count = 0;
  };
  ImageSums suns;                                                        ///< evaluation_suns(), on white
  std::array<ImageSums, kLightingCount> lightings{};                     ///< as LevelMeasures::lightings
  std::array<Foliage, kEvaluationLights.size()> foliage{}, reference{};  ///< [light]

  void add(const LightSums& other) {
    suns.add(other.suns);
    for (std::size_t i = 0; i < kLightingCount; ++i) lightings[i].add(other.lightings[i]);
    for (const auto& [mine, others] : {std::pair(&foliage, &other.foliage), std::pair(&reference, &other.reference)})
      for (std::size_t light = 0; light < kEvaluationLights.size(); ++light) {
        (*mine)[light].luminance += (*others)[light].luminance;
        (*mine)[light].pixel_count += (*others)[light].pixel_count;
      }
  }

  /// Mean luminance of foliage over the reference's; 1 if either shows none.
  [[nodiscard]] double luminance_ratio(std::size_t light) const {
    const Foliage &mine = foliage[light], &theirs = reference[light];
    if (mine.pixel_count == 0 || !(theirs.luminance > 0.0)) return 1.0;
    return mine.luminance / static_cast<double>(mine.pixel_count) / (theirs.luminance / static_cast<double>(theirs.pixel_count));
  }
};

void add_foliage(const UnlitImage& unlit, std::span<const float> luminances, LightSums::Foliage& foliage) {
  for (std::size_t pixel = 0; pixel < luminances.size(); ++pixel) {
    if (unlit.pixel_surfaces[pixel] == kNone) continue;
    foliage.luminance += double{luminances[pixel]};
    ++foliage.pixel_count;
  }
}

void set_ground(const UnlitImage& unlit, float ground, std::vector<float>& luminances) {
  for (std::size_t pixel = 0; pixel < luminances.size(); ++pixel)
    if (unlit.pixel_surfaces[pixel] == kNone) luminances[pixel] = ground;
}

/// Compares under each light before each ground. Light on leaves does not depend on the ground.
void add_lightings(const UnlitImage& image, const UnlitImage& source, double mean_tone, LightSums& sums) {
  for (std::size_t light = 0; light < kEvaluationLights.size(); ++light)
    for (const glm::dvec3& sun : evaluation_light_suns()) {
      const auto lit = [&](const UnlitImage& unlit) {
        return leaf_luminances(unlit, sun, kEvaluationLights[light].translucency, mean_tone, 0.0f);
      };
      std::vector<float> shown = lit(image), expected = lit(source);
      add_foliage(image, shown, sums.foliage[light]);
      add_foliage(source, expected, sums.reference[light]);
      for (std::size_t ground = 0; ground < kEvaluationGrounds.size(); ++ground) {
        const float behind = kEvaluationWhite * static_cast<float>(kEvaluationGrounds[ground]);
        set_ground(image, behind, shown);
        set_ground(source, behind, expected);
        sums.lightings[light * kEvaluationGrounds.size() + ground].add(compare_luminance(shown, expected, image.size_px));
      }
    }
}

/// Draws both once a camera, and lights them in all ways.
LightSums light_sums(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference) {
  return sum_over_cameras<LightSums>(reference, [&](std::size_t camera) {
    const UnlitImage image = render_unlit(level, looks, reference.cameras[camera], reference.size_px);
    const UnlitImage source = render_unlit(reference.level, reference.looks, reference.cameras[camera], reference.size_px);
    LightSums sums;
    add_lightings(image, source, reference.mean_tone, sums);
    if (!reference.suns_and_frames) return sums;
    for (const glm::dvec3& sun : evaluation_suns())
      sums.suns.add(compare_luminance(lit_image(image, sun).luminance, lit_image(source, sun).luminance, reference.size_px));
    return sums;
  });
}

ImageSums frames_sums(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference) {
  return sum_over_cameras<ImageSums>(reference, [&](std::size_t camera) {
    const std::vector<float> mean = render_temporal_mean(level, looks, reference.cameras[camera], reference.size_px);
    return compare_luminance(mean, reference.frame_means[camera], reference.size_px);
  });
}

}  // namespace

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

SurfaceColour reference_colour(ReferenceKind reference) {
  return reference == ReferenceKind::meshes ? SurfaceColour::textured : SurfaceColour::mean;
}

Result<Reference> make_reference(const ReferenceSurface& surface, const EvaluateOptions& options) {
  const Mesh& mesh = surface.level.mesh;
  if (mesh.positions.empty()) return Error{Status::invalid_argument, "the plant has no leaves: there is nothing to simplify"};
  COPPICE_TRY(looks, surface_looks(surface.materials, surface.images, reference_colour(options.reference)));
  const double diagonal_m = box_diagonal_m(mesh), area_m2 = surface_area_m2(mesh);
  if (!std::isfinite(diagonal_m) || !(area_m2 > 0.0)) return Error{Status::invalid_argument, "the foliage has no area, or is not finite"};
  Reference reference{.size_px = options.size_px,
                      .suns_and_frames = options.suns_and_frames,
                      .level = surface.level,
                      .looks = std::move(looks),
                      .cameras = {},
                      .images = {},
                      .samples = sample_surface(mesh, kSurfacePoints),
                      .tree = TriangleTree(mesh),
                      .area_m2 = area_m2,
                      .diagonal_m = diagonal_m};
  const Sphere sphere = evaluation_sphere(mesh);
  for (const glm::dvec3& direction : evaluation_directions(kEvaluationCameraCount))
    reference.cameras.push_back(evaluation_camera(direction, sphere, options.view_distance_radii));
  reference.images.resize(reference.cameras.size());
  if (options.suns_and_frames) reference.frame_means.resize(reference.cameras.size());
  std::vector<ToneSum> tones(reference.cameras.size());
  parallel_for(reference.cameras.size(), [&](std::size_t camera) {
    const EvaluationCamera& from = reference.cameras[camera];
    const UnlitImage unlit = render_unlit(reference.level, reference.looks, from, options.size_px);
    reference.images[camera] = lit_image(unlit, evaluation_sun());
    tones[camera] = tone_sum(unlit);
    if (options.suns_and_frames)
      reference.frame_means[camera] = render_temporal_mean(reference.level, reference.looks, from, options.size_px);
  });
  ToneSum all;
  for (const ToneSum& of_camera : tones) {
    all.sum += of_camera.sum;
    all.pixel_count += of_camera.pixel_count;
  }
  if (all.sum > 0.0) reference.mean_tone = all.sum / static_cast<double>(all.pixel_count);
  return reference;
}

ImageSums measure_images(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference) {
  return sum_over_cameras<ImageSums>(reference, [&](std::size_t camera) {
    return compare_images(render_evaluation(level, looks, reference.cameras[camera], reference.size_px), reference.images[camera]);
  });
}

LevelMeasures measure_level(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference, const ImageSums& sums) {
  LevelMeasures measures;
  measures.triangles = static_cast<std::uint32_t>(level.mesh.triangle_materials.size() + 2 * level.needles.size());
  measures.rmse_full = sums.rmse(0);
  measures.rmse_quarter = sums.rmse(1);
  measures.rmse_sixteenth = sums.rmse(2);
  measures.coverage = sums.coverage_ratio();
  measures.soft_iou = sums.soft_iou();
  const Mesh surface = level_surface(level);
  measures.area_ratio = level_area_m2(level) / reference.area_m2;
  const SurfaceDistance distance = symmetric_distance(distance_to_surface(sample_surface(surface, kSurfacePoints), reference.tree),
                                                      distance_to_surface(reference.samples, TriangleTree(surface)));
  measures.hausdorff = distance.max_m / reference.diagonal_m;
  measures.mean_distance = distance.mean_m / reference.diagonal_m;
  const LightSums lights = light_sums(level, looks, reference);
  for (std::size_t i = 0; i < kLightingCount; ++i)
    measures.lightings[i] = {lights.lightings[i].rmse(0), lights.lightings[i].rmse(2),
                             lights.luminance_ratio(i / kEvaluationGrounds.size())};
  if (reference.suns_and_frames) {
    const ImageSums frames = frames_sums(level, looks, reference);
    measures.lit = LevelMeasures::Lit{lights.suns.rmse(0), lights.suns.rmse(2), frames.rmse(0), frames.rmse(2)};
  }
  return measures;
}

}  // namespace coppice::bake
