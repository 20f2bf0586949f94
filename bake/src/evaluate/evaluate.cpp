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
#include "leaf_cards.h"
#include "material_split.h"
#include "parallel_for.h"
#include "stored_level.h"
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

/// What pictures and distances are compared with, and what it shows. Refers to what it is made of.
struct ReferenceSurface {
  const Mesh& mesh;
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
  const StoredLevel* stored = nullptr;  ///< to be compared with it too
};

/// The source, and everything about it that each comparison needs.
struct Reference {
  std::uint32_t size_px = 0;
  std::vector<EvaluationCamera> cameras;
  std::vector<EvaluationImage> images;  ///< by camera
  SurfaceSamples samples;
  TriangleTree tree;
  double area_m2 = 0.0, diagonal_m = 0.0;
};

/// Simplifiers are judged by where they put leaves, pictures of the plant as modelled by what they show.
SurfaceColour reference_colour(ReferenceKind reference) {
  return reference == ReferenceKind::meshes ? SurfaceColour::textured : SurfaceColour::mean;
}

Result<Reference> make_reference(const ReferenceSurface& surface, const EvaluateOptions& options) {
  const Mesh& mesh = surface.mesh;
  if (mesh.positions.empty()) return Error{Status::invalid_argument, "the plant has no leaves: there is nothing to simplify"};
  COPPICE_TRY(looks, surface_looks(surface.materials, surface.images, reference_colour(options.reference)));
  const double diagonal_m = box_diagonal_m(mesh), area_m2 = surface_area_m2(mesh);
  if (!std::isfinite(diagonal_m) || !(area_m2 > 0.0)) return Error{Status::invalid_argument, "the foliage has no area, or is not finite"};
  const Sphere sphere = evaluation_sphere(mesh);
  Reference reference{options.size_px, {}, {}, sample_surface(mesh, kSurfacePoints), TriangleTree(mesh), area_m2, diagonal_m};
  for (const glm::dvec3& direction : evaluation_directions(kEvaluationCameraCount))
    reference.cameras.push_back(evaluation_camera(direction, sphere));
  reference.images.resize(reference.cameras.size());
  parallel_for(reference.cameras.size(), [&](std::size_t camera) {
    reference.images[camera] = render_evaluation(mesh, looks, reference.cameras[camera], options.size_px);
  });
  return reference;
}

ImageSums image_sums(const Mesh& mesh, const std::vector<SurfaceLook>& looks, const Reference& reference) {
  std::vector<ImageSums> by_camera(reference.cameras.size());
  parallel_for(by_camera.size(), [&](std::size_t camera) {
    by_camera[camera] =
        compare_images(render_evaluation(mesh, looks, reference.cameras[camera], reference.size_px), reference.images[camera]);
  });
  ImageSums all;
  for (const ImageSums& sums : by_camera) all.add(sums);
  return all;
}

LevelMeasures measure(const Mesh& mesh, const std::vector<SurfaceLook>& looks, const Reference& reference) {
  LevelMeasures level;
  level.triangles = static_cast<std::uint32_t>(mesh.triangle_materials.size());
  const ImageSums sums = image_sums(mesh, looks, reference);
  level.rmse_full = sums.rmse(0);
  level.rmse_quarter = sums.rmse(1);
  level.rmse_sixteenth = sums.rmse(2);
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
  if (options.size_px == 0 || options.size_px > kMaxEvaluationSizePx || options.size_px % kEvaluationSizeStepPx != 0)
    return Error{Status::invalid_argument, "a picture size is not a multiple of 16 up to 4096", Error::kNoOffset,
                 std::to_string(options.size_px)};
  return {};
}

/// What every method is measured with.
struct Bench {
  const Reference& reference;
  const std::vector<SurfaceLook>& looks;  ///< of the simplified plant's materials
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
    LevelMeasures level = measure(meshes[i], bench.looks, bench.reference);
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

/// The pictures for a reader: of the reference now, and the view for those of the levels.
Result<ThumbnailView> make_thumbnails(const ReferenceSurface& surface, const SimplifyInput& input, const EvaluateOptions& options,
                                      EvaluationReport& report) {
  const SurfaceColour colour = reference_colour(options.reference);
  COPPICE_TRY(source_view, thumbnail_view(surface.mesh, surface.materials, surface.images, colour));
  COPPICE_TRY(png, render_thumbnail_png(surface.mesh, source_view));
  report.source_picture_png = std::move(png);
  return thumbnail_view(surface.mesh, input.shown.materials, input.shown.images, colour);
}

Result<EvaluationReport::Stored> measure_stored(const StoredLevel& stored, std::uint32_t leaf_count, const Reference& reference,
                                                const EvaluateOptions& options) {
  COPPICE_TRY(looks, surface_looks(stored.materials, stored.images, reference_colour(options.reference)));
  EvaluationReport::Stored measured{stored.is_leaf_meshes, measure(stored.mesh, looks, reference)};
  measured.level.fraction = 1.0;
  measured.level.leaves = leaf_count;
  return measured;
}

/// input  without leaf counts
Result<EvaluationReport> evaluate_against(const ReferenceSurface& surface, const std::string& plant, SimplifyInput input,
                                          const EvaluateOptions& options, const EvaluateProgress& progress) {
  const std::size_t threads = options.thread_count > 0 ? options.thread_count : static_cast<std::size_t>(tbb::info::default_concurrency());
  const tbb::global_control thread_limit(tbb::global_control::max_allowed_parallelism, threads);
  COPPICE_TRY(reference, make_reference(surface, options));
  COPPICE_TRY(looks, surface_looks(input.shown.materials, input.shown.images, reference_colour(options.reference)));
  for (const double fraction : options.fractions) input.leaf_counts.push_back(level_leaves(input.shown.foliage.leaf_count(), fraction));

  EvaluationReport report;
  report.plant = plant;
  report.source_leaves = input.shown.foliage.leaf_count();
  report.reference = options.reference;
  report.size_px = options.size_px;
  report.source_triangles = static_cast<std::uint32_t>(surface.mesh.triangle_materials.size());
  std::optional<ThumbnailView> thumbnails;
  if (options.keep_pictures) {
    COPPICE_TRY(view, make_thumbnails(surface, input, options, report));
    thumbnails = std::move(view);
  }
  if (surface.stored != nullptr) {
    COPPICE_TRY(stored, measure_stored(*surface.stored, report.source_leaves, reference, options));
    report.stored = std::move(stored);
  }
  const Bench bench{reference, looks, options.fractions, thumbnails};
  for (const Method method : options.methods) {
    COPPICE_TRY(measures, evaluate_method(method, input, bench, progress));
    report.methods.push_back(std::move(measures));
  }
  return report;
}

}  // namespace

const char* reference_name(ReferenceKind reference) {
  return reference == ReferenceKind::meshes ? "meshes" : "quads";
}

std::array<std::string, 3> rmse_names(std::uint32_t size_px) {
  std::array<std::string, 3> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = "rmse_" + std::to_string(size_px / ImageSums::kFactors[i]);
  return names;
}

std::uint32_t level_leaves(std::uint32_t leaf_count, double fraction) {
  return std::max(1u, static_cast<std::uint32_t>(std::floor(fraction * leaf_count + 1e-6)));
}

Result<EvaluationReport> evaluate_foliage(const std::string& plant, const ShownFoliage& shown, const EvaluateOptions& options,
                                          const EvaluateProgress& progress) {
  COPPICE_CHECK(check_options(options));
  if (options.reference == ReferenceKind::meshes) return Error{Status::invalid_argument, "leaf quads alone have no meshes to compare with"};
  const Mesh quads = foliage_mesh(shown.foliage);
  return evaluate_against(ReferenceSurface{quads, shown.materials, shown.images, nullptr}, plant, SimplifyInput{shown, {}}, options,
                          progress);
}

Result<EvaluationReport> evaluate_plant(Plant plant, const EvaluateOptions& options, const EvaluateProgress& progress) {
  COPPICE_CHECK(check_options(options));
  COPPICE_TRY(foliage, card_foliage(plant));
  const bool against_quads = options.reference == ReferenceKind::quads;
  const Mesh quads = against_quads ? foliage_mesh(foliage) : Mesh{};
  StoredLevel stored;
  if (!against_quads) {
    COPPICE_TRY(level, stored_finest_level(plant, foliage));
    stored = std::move(level);
  }
  const ReferenceSurface surface{against_quads ? quads : plant.foliage, plant.materials, plant.images, against_quads ? nullptr : &stored};
  COPPICE_TRY(report,
              evaluate_against(surface, plant.name, SimplifyInput{{foliage, plant.materials, plant.images}, {}}, options, progress));
  report.warnings = plant.warnings;
  return report;
}

Result<EvaluationReport> evaluate(const std::filesystem::path& input, const EvaluateOptions& options, const EvaluateProgress& progress) {
  COPPICE_CHECK(check_options(options));
  if (progress) progress("import", 0.0);
  COPPICE_TRY(plant, import_gltf(input, options.import));
  split_materials(plant);  // as the baker does: leaves have the colours of their vertices
  return evaluate_plant(std::move(plant), options, progress);
}

}  // namespace coppice::bake
