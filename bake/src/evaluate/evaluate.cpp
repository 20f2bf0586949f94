#include "evaluate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "evaluation_render.h"
#include "gltf_write.h"
#include "image_measures.h"
#include "leaf_quads.h"
#include "parallel_for.h"
#include "surface_distance.h"
#include "thumbnail.h"

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

/// The source, and everything about it that each comparison needs.
struct Reference {
  Mesh mesh;
  std::vector<SurfaceLook> looks;
  std::vector<EvaluationCamera> cameras;
  std::vector<EvaluationImage> images;  ///< by camera
  SurfaceSamples samples;
  TriangleTree tree;
  double area_m2 = 0.0, diagonal_m = 0.0;
};

Result<Reference> make_reference(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images) {
  if (foliage.quads.empty()) return Error{Status::invalid_argument, "the plant has no leaves"};
  Mesh mesh = foliage_mesh(foliage);
  COPPICE_TRY(looks, surface_looks(materials, images));
  const double diagonal_m = box_diagonal_m(mesh), area_m2 = surface_area_m2(mesh);
  if (!std::isfinite(diagonal_m) || !(area_m2 > 0.0)) return Error{Status::invalid_argument, "the foliage has no area, or is not finite"};
  const Sphere sphere = evaluation_sphere(mesh);
  Reference reference{std::move(mesh), std::move(looks), {}, {}, {}, TriangleTree({}), area_m2, diagonal_m};
  reference.samples = sample_surface(reference.mesh, kSurfacePoints);
  reference.tree = TriangleTree(reference.mesh);
  for (const glm::dvec3& direction : evaluation_directions(kEvaluationCameraCount))
    reference.cameras.push_back(evaluation_camera(direction, sphere));
  reference.images.resize(reference.cameras.size());
  parallel_for(reference.cameras.size(), [&](std::size_t camera) {
    reference.images[camera] = render_evaluation(reference.mesh, reference.looks, reference.cameras[camera], kEvaluationSizePx);
  });
  return reference;
}

ImageSums image_sums(const Mesh& mesh, const Reference& reference) {
  std::vector<ImageSums> by_camera(reference.cameras.size());
  parallel_for(by_camera.size(), [&](std::size_t camera) {
    by_camera[camera] =
        compare_images(render_evaluation(mesh, reference.looks, reference.cameras[camera], kEvaluationSizePx), reference.images[camera]);
  });
  ImageSums all;
  for (const ImageSums& sums : by_camera) all.add(sums);
  return all;
}

LevelMeasures measure(const Mesh& mesh, const Reference& reference) {
  LevelMeasures level;
  level.triangles = static_cast<std::uint32_t>(mesh.triangle_materials.size());
  const ImageSums sums = image_sums(mesh, reference);
  level.rmse_256 = sums.rmse(0);
  level.rmse_64 = sums.rmse(1);
  level.rmse_16 = sums.rmse(2);
  level.coverage = sums.coverage_ratio();
  level.soft_iou = sums.soft_iou();
  level.area_ratio = surface_area_m2(mesh) / reference.area_m2;
  const SurfaceDistance distance = symmetric_distance(distance_to_surface(sample_surface(mesh, kSurfacePoints), reference.tree),
                                                      distance_to_surface(reference.samples, TriangleTree(mesh)));
  level.hausdorff = distance.max_m / reference.diagonal_m;
  level.mean_distance = distance.mean_m / reference.diagonal_m;
  return level;
}

Result<void> check_options(const EvaluateOptions& options) {
  if (options.methods.empty()) return Error{Status::invalid_argument, "no methods to evaluate"};
  if (options.fractions.empty()) return Error{Status::invalid_argument, "no levels to evaluate"};
  for (const double fraction : options.fractions)
    if (!(fraction > 0.0 && fraction <= 1.0))
      return Error{Status::invalid_argument, "a level is not a fraction above 0 and up to 1", Error::kNoOffset, std::to_string(fraction)};
  return {};
}

/// What every method is measured with.
struct Bench {
  const Reference& reference;
  const std::vector<double>& fractions;
  const std::optional<ThumbnailView>& thumbnails;  ///< none: no pictures are kept
};

/// Simplifying takes the first nine tenths of a method's bar, measuring the rest.
constexpr double kSimplifyShare = 0.9;

Result<MethodMeasures> evaluate_method(Method method, const SimplifyInput& input, const Bench& bench, const EvaluateProgress& progress) {
  const auto show = [&](double fraction) {
    if (progress) progress(method_name(method), fraction);
  };
  MethodMeasures measures;
  measures.method = method;
  show(0.0);
  const auto start = std::chrono::steady_clock::now();
  COPPICE_TRY(meshes, simplify_foliage(method, input, [&](double fraction) { show(kSimplifyShare * fraction); }));
  measures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    show(kSimplifyShare + (1.0 - kSimplifyShare) * static_cast<double>(i) / static_cast<double>(meshes.size()));
    LevelMeasures level = measure(meshes[i], bench.reference);
    level.fraction = bench.fractions[i];
    level.leaves = input.leaf_counts[i];
    if (bench.thumbnails) {
      COPPICE_TRY(png, render_thumbnail_png(meshes[i], *bench.thumbnails));
      level.picture_png = std::move(png);
    }
    measures.levels.push_back(std::move(level));
  }
  return measures;
}

}  // namespace

std::uint32_t level_leaves(std::uint32_t leaf_count, double fraction) {
  return std::max(1u, static_cast<std::uint32_t>(std::floor(fraction * leaf_count + 1e-6)));
}

Result<EvaluationReport> evaluate_foliage(const std::string& plant, const Foliage& foliage, const std::vector<Material>& materials,
                                          const std::vector<Image>& images, const EvaluateOptions& options,
                                          const EvaluateProgress& progress) {
  COPPICE_CHECK(check_options(options));
  const std::size_t threads = options.thread_count > 0 ? options.thread_count : static_cast<std::size_t>(tbb::info::default_concurrency());
  const tbb::global_control thread_limit(tbb::global_control::max_allowed_parallelism, threads);
  COPPICE_TRY(reference, make_reference(foliage, materials, images));
  SimplifyInput input{foliage, materials, images, {}};
  for (const double fraction : options.fractions) input.leaf_counts.push_back(level_leaves(foliage.leaf_count(), fraction));

  EvaluationReport report;
  report.plant = plant;
  report.source_leaves = foliage.leaf_count();
  report.source_triangles = static_cast<std::uint32_t>(reference.mesh.triangle_materials.size());
  std::optional<ThumbnailView> thumbnails;
  if (options.keep_pictures) {
    COPPICE_TRY(view, thumbnail_view(reference.mesh, materials, images));
    COPPICE_TRY(png, render_thumbnail_png(reference.mesh, view));
    thumbnails = std::move(view);
    report.source_picture_png = std::move(png);
  }
  const Bench bench{reference, options.fractions, thumbnails};
  for (const Method method : options.methods) {
    COPPICE_TRY(measures, evaluate_method(method, input, bench, progress));
    report.methods.push_back(std::move(measures));
  }
  return report;
}

Result<EvaluationReport> evaluate(const std::filesystem::path& input, const EvaluateOptions& options, const EvaluateProgress& progress) {
  COPPICE_CHECK(check_options(options));
  if (progress) progress("import", 0.0);
  COPPICE_TRY(plant, import_gltf(input, options.import));
  COPPICE_TRY(foliage, fit_leaf_quads(plant));
  COPPICE_TRY(report, evaluate_foliage(plant.name, foliage, plant.materials, plant.images, options, progress));
  report.warnings = plant.warnings;
  return report;
}

}  // namespace coppice::bake
