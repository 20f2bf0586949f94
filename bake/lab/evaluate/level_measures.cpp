#include "level_measures.h"

#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

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
template <class CameraSums>
ImageSums sum_over_cameras(const Reference& reference, const CameraSums& camera_sums) {
  std::vector<ImageSums> by_camera(reference.cameras.size());
  parallel_for(by_camera.size(), [&](std::size_t camera) { by_camera[camera] = camera_sums(camera); });
  ImageSums all;
  for (const ImageSums& sums : by_camera) all.add(sums);
  return all;
}

/// Draws both once a camera, and lights them with each sun.
ImageSums suns_sums(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference) {
  return sum_over_cameras(reference, [&](std::size_t camera) {
    const UnlitImage image = render_unlit(level, looks, reference.cameras[camera], reference.size_px);
    const UnlitImage source = render_unlit(reference.level, reference.looks, reference.cameras[camera], reference.size_px);
    ImageSums sums;
    for (const glm::dvec3& sun : evaluation_suns())
      sums.add(compare_luminance(lit_image(image, sun).luminance, lit_image(source, sun).luminance, reference.size_px));
    return sums;
  });
}

ImageSums frames_sums(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference) {
  return sum_over_cameras(reference, [&](std::size_t camera) {
    const std::vector<float> mean = render_temporal_mean(level, looks, reference.cameras[camera], reference.size_px);
    return compare_luminance(mean, reference.frame_means[camera], reference.size_px);
  });
}

}  // namespace

SurfaceColour reference_colour(ReferenceKind reference) {
  return reference == ReferenceKind::meshes ? SurfaceColour::textured : SurfaceColour::mean;
}

Result<Reference> make_reference(const ReferenceSurface& surface, const EvaluateOptions& options) {
  const Mesh& mesh = surface.mesh;
  if (mesh.positions.empty()) return Error{Status::invalid_argument, "the plant has no leaves: there is nothing to simplify"};
  COPPICE_TRY(looks, surface_looks(surface.materials, surface.images, reference_colour(options.reference)));
  const double diagonal_m = box_diagonal_m(mesh), area_m2 = surface_area_m2(mesh);
  if (!std::isfinite(diagonal_m) || !(area_m2 > 0.0)) return Error{Status::invalid_argument, "the foliage has no area, or is not finite"};
  Reference reference{.size_px = options.size_px,
                      .suns_and_frames = options.suns_and_frames,
                      .level = Level{mesh},
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
  parallel_for(reference.cameras.size(), [&](std::size_t camera) {
    const EvaluationCamera& from = reference.cameras[camera];
    reference.images[camera] = render_evaluation(reference.level, reference.looks, from, options.size_px);
    if (options.suns_and_frames)
      reference.frame_means[camera] = render_temporal_mean(reference.level, reference.looks, from, options.size_px);
  });
  return reference;
}

ImageSums measure_images(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference) {
  return sum_over_cameras(reference, [&](std::size_t camera) {
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
  if (reference.suns_and_frames) {
    const ImageSums suns = suns_sums(level, looks, reference), frames = frames_sums(level, looks, reference);
    measures.lit = LevelMeasures::Lit{suns.rmse(0), suns.rmse(2), frames.rmse(0), frames.rmse(2)};
  }
  return measures;
}

}  // namespace coppice::bake
