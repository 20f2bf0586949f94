#include "evaluate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <tbb/global_control.h>
#include <tbb/info.h>

#include "evaluation_render.h"
#include "gltf_write.h"
#include "leaf_cards.h"
#include "leaf_quads.h"
#include "leaf_shade.h"
#include "material_split.h"
#include "measures.h"
#include "thumbnail.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

Result<void> check_options(const EvaluateOptions& options) {
  if (options.methods.empty() && options.level_sets.empty()) return Error{Status::invalid_argument, "no methods to evaluate"};
  if (options.fractions.empty()) return Error{Status::invalid_argument, "no levels to evaluate"};
  for (const double fraction : options.fractions)
    if (!(fraction > 0.0 && fraction <= 1.0))
      return Error{Status::invalid_argument, "a level is not a fraction above 0 and up to 1", Error::kNoOffset, std::to_string(fraction)};
  if (options.size_px == 0 || options.size_px > kMaxEvaluationSizePx || options.size_px % kEvaluationSizeStepPx != 0)
    return Error{Status::invalid_argument, "a picture size is not a multiple of 16 up to 4096", Error::kNoOffset,
                 std::to_string(options.size_px)};
  if (!(options.view_distance_radii > 1.0 && options.view_distance_radii <= kMaxViewDistanceRadii))
    return Error{Status::invalid_argument, "a view distance is not above 1 and up to 1000 radii", Error::kNoOffset,
                 std::to_string(options.view_distance_radii)};
  return {};
}

/// What every method is measured with.
struct Bench {
  const Reference& reference;
  const EvaluateOptions& options;
  const Mesh& source;            ///< frames the pictures for a reader
  std::uint32_t leaf_count = 0;  ///< the source's
};

/// One of the levels of which the best counts. Holds references.
struct Candidate {
  const std::string& parameters;
  const Level& level;
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
};

/// The product of three errors, so that none is sacrificed for another.
double badness(const ImageSums& sums) {
  return sums.rmse(0) * sums.rmse(1) * sums.rmse(2);
}

/// Measures the candidate with the smallest badness; of equals the first.
Result<LevelMeasures> measure_best(const std::vector<Candidate>& candidates, double fraction, const Bench& bench) {
  const SurfaceColour colour = reference_colour(bench.options.reference);
  const Candidate* best = nullptr;
  std::vector<SurfaceLook> best_looks;
  ImageSums best_sums;
  for (const Candidate& candidate : candidates) {
    COPPICE_TRY(looks, surface_looks(candidate.materials, candidate.images, colour));
    const ImageSums sums = measure_images(candidate.level, looks, bench.reference);
    if (best != nullptr && !(badness(sums) < badness(best_sums))) continue;
    best = &candidate;
    best_looks = std::move(looks);
    best_sums = sums;
  }
  LevelMeasures measures = measure_level(best->level, best_looks, bench.reference, best_sums);
  measures.parameters = best->parameters;
  measures.fraction = fraction;
  measures.leaves = level_leaves(bench.leaf_count, fraction);
  if (bench.options.keep_pictures) {
    COPPICE_TRY(view, thumbnail_view(bench.source, best->materials, best->images, colour));
    COPPICE_TRY(png, render_thumbnail_png(best->level, view));
    measures.picture_png = std::move(png);
  }
  return measures;
}

/// Simplifying takes this share of a method's progress bar, measuring the rest.
constexpr double kSimplifyShare = 0.9;

Result<MethodMeasures> evaluate_method(Method method, const SimplifyInput& input, const Bench& bench, const EvaluateProgress& progress) {
  const auto show = [&](double fraction) {
    if (progress) progress(method_name(method), fraction);
  };
  MethodMeasures measures;
  measures.name = method_name(method);
  show(0.0);
  const auto start = std::chrono::steady_clock::now();
  COPPICE_TRY(variants, simplify_foliage(method, input, [&](double fraction) { show(kSimplifyShare * fraction); }));
  measures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::vector<double>& fractions = bench.options.fractions;
  for (std::size_t i = 0; i < fractions.size(); ++i) {
    show(kSimplifyShare + (1.0 - kSimplifyShare) * static_cast<double>(i) / static_cast<double>(fractions.size()));
    std::vector<Candidate> candidates;
    for (const Variant& variant : variants)
      candidates.push_back({variant.parameters, variant.levels[i], input.shown.materials, input.shown.images});
    COPPICE_TRY(level, measure_best(candidates, fractions[i], bench));
    measures.levels.push_back(std::move(level));
  }
  return measures;
}

/// The files with no more triangles than requested; if all have more, the smallest.
std::vector<Candidate> comparable(const std::vector<ForeignLevel>& files, std::uint32_t triangle_count) {
  const auto count_of = [](const ForeignLevel& file) { return file.level.mesh.triangle_materials.size(); };
  const std::size_t smallest = count_of(*std::ranges::min_element(files, {}, count_of));
  std::vector<Candidate> candidates;
  for (const ForeignLevel& file : files)
    if (count_of(file) <= std::max<std::size_t>(triangle_count, smallest))
      candidates.push_back({file.parameters, file.level, file.materials, file.images});
  return candidates;
}

std::string too_large(const std::string& name, const LevelMeasures& level, std::uint32_t triangle_count) {
  return name + " has " + std::to_string(level.triangles) + " triangles at level " + level_file_name(level.fraction) + ", more than the " +
         std::to_string(triangle_count) + " of the others";
}

/// warnings  gets a line for each level that is too large to compare
Result<MethodMeasures> evaluate_level_set(const LevelSet& set, const Bench& bench, const EvaluateProgress& progress,
                                          std::vector<std::string>& warnings) {
  if (progress) progress(set.name.c_str(), 0.0);
  MethodMeasures measures;
  measures.name = set.name;
  const std::vector<double>& fractions = bench.options.fractions;
  COPPICE_TRY(read, read_level_set(set, fractions));
  for (std::size_t i = 0; i < fractions.size(); ++i) {
    const std::uint32_t triangle_count = 2 * level_leaves(bench.leaf_count, fractions[i]);
    COPPICE_TRY(level, measure_best(comparable(read[i], triangle_count), fractions[i], bench));
    if (level.triangles > triangle_count) warnings.push_back(too_large(set.name, level, triangle_count));
    measures.levels.push_back(std::move(level));
  }
  return measures;
}

Result<std::vector<std::uint8_t>> source_picture(const ReferenceSurface& surface, const EvaluateOptions& options) {
  COPPICE_TRY(view, thumbnail_view(surface.level.mesh, surface.materials, surface.images, reference_colour(options.reference)));
  return render_thumbnail_png(surface.level, view);
}

Result<EvaluationReport::Stored> measure_stored(const StoredLevel& stored, std::uint32_t leaf_count, const Reference& reference,
                                                const EvaluateOptions& options) {
  COPPICE_TRY(looks, surface_looks(stored.materials, stored.images, reference_colour(options.reference)));
  const ImageSums sums = measure_images(stored.level, looks, reference);
  EvaluationReport::Stored measured{stored.is_leaf_meshes, measure_level(stored.level, looks, reference, sums)};
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
  for (const double fraction : options.fractions) input.leaf_counts.push_back(level_leaves(input.shown.foliage.leaf_count(), fraction));
  if (options.setup == Setup::paper) input.view_distance_radii = static_cast<float>(options.view_distance_radii);

  EvaluationReport report;
  static_cast<EvaluationSetup&>(report) = options;
  report.plant = plant;
  report.source_leaves = input.shown.foliage.leaf_count();
  report.source_triangles = static_cast<std::uint32_t>(surface.level.mesh.triangle_materials.size());
  if (options.keep_pictures) {
    COPPICE_TRY(png, source_picture(surface, options));
    report.source_picture_png = std::move(png);
  }
  if (surface.stored != nullptr) {
    COPPICE_TRY(stored, measure_stored(*surface.stored, report.source_leaves, reference, options));
    report.stored = std::move(stored);
  }
  const Bench bench{reference, options, surface.level.mesh, report.source_leaves};
  for (const Method method : options.methods) {
    COPPICE_TRY(measures, evaluate_method(method, input, bench, progress));
    report.methods.push_back(std::move(measures));
  }
  for (const LevelSet& set : options.level_sets) {
    COPPICE_TRY(measures, evaluate_level_set(set, bench, progress, report.warnings));
    report.methods.push_back(std::move(measures));
  }
  return report;
}

}  // namespace

const char* reference_name(ReferenceKind reference) {
  return reference == ReferenceKind::meshes ? "meshes" : "quads";
}

const char* setup_name(Setup setup) {
  return setup == Setup::paper ? "paper" : "ours";
}

std::array<std::string, 3> rmse_names(std::uint32_t size_px) {
  std::array<std::string, 3> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = "rmse_" + std::to_string(size_px / ImageSums::kFactors[i]);
  return names;
}

LevelMeasures::Lighting worst_lighting(const LevelMeasures& level) {
  LevelMeasures::Lighting worst;
  for (const LevelMeasures::Lighting& each : level.lightings) {
    worst.rmse_full = std::max(worst.rmse_full, each.rmse_full);
    worst.rmse_sixteenth = std::max(worst.rmse_sixteenth, each.rmse_sixteenth);
    if (std::abs(each.luminance - 1.0) > std::abs(worst.luminance - 1.0)) worst.luminance = each.luminance;
  }
  return worst;
}

LevelMeasures::Lighting mean_lighting(const LevelMeasures& level) {
  LevelMeasures::Lighting mean{0.0, 0.0, 0.0};
  for (const LevelMeasures::Lighting& each : level.lightings) {
    mean.rmse_full += each.rmse_full / kLightingCount;
    mean.rmse_sixteenth += each.rmse_sixteenth / kLightingCount;
    mean.luminance += each.luminance / kLightingCount;
  }
  return mean;
}

std::array<std::string, 4> lighting_names(std::uint32_t size_px) {
  const std::array<std::string, 3> rmse = rmse_names(size_px);
  return {rmse[0] + "_mean", rmse[2] + "_mean", rmse[0] + "_worst", rmse[2] + "_worst"};
}

std::array<std::string, 4> lit_names(std::uint32_t size_px) {
  const std::array<std::string, 3> rmse = rmse_names(size_px);
  return {rmse[0] + "_suns", rmse[2] + "_suns", rmse[0] + "_frames", rmse[2] + "_frames"};
}

std::uint32_t level_leaves(std::uint32_t leaf_count, double fraction) {
  return std::max(1u, static_cast<std::uint32_t>(std::floor(fraction * leaf_count + 1e-6)));
}

Result<EvaluationReport> evaluate_foliage(const std::string& plant, const ShownFoliage& shown, const EvaluateOptions& options,
                                          const EvaluateProgress& progress) {
  COPPICE_CHECK(check_options(options));
  if (options.reference == ReferenceKind::meshes) return Error{Status::invalid_argument, "leaf quads alone have no meshes to compare with"};
  const Level quads = level_of(foliage_mesh(shown.foliage));
  return evaluate_against(ReferenceSurface{quads, shown.materials, shown.images, nullptr}, plant, SimplifyInput{shown, {}}, options,
                          progress);
}

Result<Foliage> source_foliage(Plant& plant, Setup setup) {
  if (setup == Setup::ours) return card_foliage(plant);
  COPPICE_TRY(masks, alpha_masks(plant.materials, plant.images));
  const std::vector<glm::vec3> colors = mean_texel_colors(plant.materials, plant.images, masks);
  for (std::size_t i = 0; i < plant.materials.size(); ++i) {
    Material& material = plant.materials[i];
    material.base_color = {colors[i], 1.0f};
    material.image = kNone;
    material.alpha_cutoff = 0.0f;
  }
  plant.images.clear();
  return fit_leaf_quads(plant);
}

Result<EvaluationReport> evaluate_plant(Plant plant, const EvaluateOptions& options, const EvaluateProgress& progress) {
  COPPICE_CHECK(check_options(options));
  COPPICE_TRY(foliage, source_foliage(plant, options.setup));
  const SimplifyInput input{{foliage, plant.materials, plant.images}, {}};
  const auto evaluated = [&](const Level& level, const StoredLevel* stored) {
    return evaluate_against({level, plant.materials, plant.images, stored}, plant.name, input, options, progress);
  };
  const auto against_meshes = [&]() -> Result<EvaluationReport> {
    COPPICE_TRY(stored, stored_finest_level(plant, foliage));
    return evaluated(modelled_level(plant.foliage, plant.materials), &stored);
  };
  COPPICE_TRY(report, options.reference == ReferenceKind::quads ? evaluated(level_of(foliage_mesh(foliage)), nullptr) : against_meshes());
  report.warnings.insert(report.warnings.begin(), plant.warnings.begin(), plant.warnings.end());
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
