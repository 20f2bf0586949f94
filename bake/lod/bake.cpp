#include "bake.h"

#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "bounds.h"
#include "collapse_geometric.h"
#include "collapse_image.h"
#include "collapse_information.h"
#include "error_table.h"
#include "leaf_cards.h"
#include "leaf_mesh_parts.h"
#include "leaf_normals.h"
#include "material_split.h"
#include "mesh_error.h"
#include "occlusion_areas.h"
#include "printable.h"
#include "progress.h"
#include "stopwatch.h"
#include "texture_regions.h"
#include "tree_order.h"
#include "wood_joints.h"
#include "wood_lods.h"

namespace coppice::bake {
namespace {

std::uint64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

ProgressFunction stage_of(const StageProgress& progress, const char* name) {
  return [&progress, name](double fraction) { progress(name, fraction); };
}

CollapseOptions collapse_options(const BakeOptions& options, const Foliage& foliage, BakeReport& report) {
  CollapseOptions collapse = options.collapse;
  collapse.resolution_px = metric_resolution_px(options.metric, foliage, collapse.resolution_px);
  if (collapse.resolution_px < options.collapse.resolution_px)
    report.warnings.push_back("leaves overlap so much that collapses are weighed in views of " + std::to_string(collapse.resolution_px) +
                              " px, not " + std::to_string(options.collapse.resolution_px));
  return collapse;
}

Result<CollapseResult> collapse_by_queries(const CollapseOptions& options, const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                           const StageProgress& progress, BakeReport& report) {
  COPPICE_TRY(queries, OcclusionAreas::create({shown, views, options.resolution_px}));
  report.area_device = queries->device_name();
  report.area_every_step = shown.foliage.leaf_count() <= kMaxMeasuredLeaves;
  AreaSource areas{{}, report.area_every_step};
  areas.measure = [&](const AreaRequest& request, std::span<std::uint32_t> areas_px) {
    const bool is_first = request.changed.empty();
    return queries->measure(request, areas_px, is_first ? stage_of(progress, "areas") : ProgressFunction());
  };
  return collapse_by_mutual_information(shown, views, options, stage_of(progress, "collapse"), areas);
}

Result<CollapseResult> collapse_by(const BakeOptions& options, const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                   const StageProgress& stages, BakeReport& report) {
  const CollapseOptions collapse = collapse_options(options, shown.foliage, report);
  const ProgressFunction progress = stage_of(stages, "collapse");
  if (options.areas == Areas::vulkan) return collapse_by_queries(collapse, shown, views, stages, report);
  if (options.metric == Metric::mi) return collapse_by_mutual_information(shown, views, collapse, progress);
  if (options.metric == Metric::geometric) return replay(shown, views, collapse, collapse_by_similarity(shown.foliage, progress));
  return collapse_by_image_error(shown, views, collapse, ImageErrorOptions{}, progress);
}

/// The foliage of a plant that is all wood. A tree has at least one leaf: this one is a point in the middle of the wood, and invisible.
Foliage bare_foliage(const Mesh& wood) {
  const auto [low, high] = box_of(wood.positions);
  Foliage foliage;
  foliage.quads.emplace_back().fill(0.5f * (low + high));
  foliage.cards.push_back(0);
  foliage.card_table.push_back({.material = wood.triangle_materials.front(), .uv = {}});
  return foliage;
}

}  // namespace

std::uint32_t metric_resolution_px(Metric metric, const Foliage& foliage, std::uint32_t resolution_px) {
  if (metric != Metric::default_metric) return resolution_px;
  // The densest plant of the tests has 3; those plants keep their full views.
  constexpr double kMaxLayers = 6.0, kMinShare = 0.375;
  double area_m2 = 0.0;
  for (const Quad& quad : foliage.quads)
    area_m2 += 0.5 * glm::length(glm::cross(glm::dvec3(quad[2] - quad[0]), glm::dvec3(quad[3] - quad[1])));
  const double side_m = 2.0 * bounding_sphere(foliage).radius;
  // Seen from all sides a quad covers half of its area on average.
  const double layers = side_m > 0.0 ? 0.5 * area_m2 / (side_m * side_m) : 0.0;
  if (layers <= kMaxLayers) return resolution_px;
  return std::max(1u, static_cast<std::uint32_t>(resolution_px * std::max(kMinShare, std::sqrt(kMaxLayers / layers))));
}

Result<void> check_areas(const BakeOptions& options) {
  if (options.areas == Areas::item_buffers || options.metric == Metric::mi) return {};
  return Error{Status::invalid_argument, kAreasNeedMi};
}

std::uint32_t metric_view_count(Metric metric, std::uint32_t leaf_count) {
  if (metric != Metric::default_metric) return 20;
  return leaf_count > 8192 ? 32 : 42;
}

Result<std::vector<std::uint8_t>> bake(const std::filesystem::path& input, const BakeOptions& options, const StageProgress& progress,
                                       BakeReport& report) {
  const auto all_threads = static_cast<std::size_t>(tbb::info::default_concurrency());
  const tbb::global_control thread_limit(tbb::global_control::max_allowed_parallelism,
                                         options.thread_count > 0 ? options.thread_count : all_threads);
  Stopwatch total, watch;

  COPPICE_CHECK(check_areas(options));
  progress("import", 0.0);
  COPPICE_TRY(plant, import_gltf(input, options.import));
  split_materials(plant);
  cut_texture_regions(plant);
  turn_normals_to_crown(plant, options.crown_normals);
  COPPICE_TRY(foliage, plant.leaves.empty() ? Result<Foliage>(bare_foliage(plant.wood)) : card_foliage(plant));
  COPPICE_TRY(views, viewpoints(options.view_count > 0 ? options.view_count : metric_view_count(options.metric, foliage.leaf_count())));
  report.source_leaves = static_cast<std::uint32_t>(plant.leaves.size());
  report.size_m = plant_size_m(plant);
  report.warnings = plant.warnings;
  report.seconds.import = watch.lap();

  progress("collapse", 0.0);
  COPPICE_TRY(collapse, collapse_by(options, {foliage, plant.materials, plant.images}, views, progress, report));
  report.seconds.visibility = collapse.visibility_seconds;
  report.seconds.collapse = watch.lap() - collapse.visibility_seconds;
  report.evaluations = collapse.sequence.evaluations;
  report.source_information = collapse.source;
  report.level_information = collapse.levels;

  KeptLeafMeshes kept = options.leaf_meshes ? keep_leaf_meshes(plant, foliage) : KeptLeafMeshes{{}, "not asked for", false};
  if (kept.too_large) report.warnings.push_back("leaf quads replace leaf meshes in close views: " + kept.note);
  report.leaf_mesh_triangles = triangle_count(kept.meshes);
  report.leaf_mesh_note = std::move(kept.note);

  BakedPlant baked;
  baked.name = printable(plant.name);  // verify() requires this
  baked.metric = static_cast<std::uint32_t>(options.metric);
  baked.tree = build_tree(foliage, collapse.sequence);
  baked.card_table = std::move(foliage.card_table);
  baked.materials = std::move(plant.materials);
  baked.images = std::move(plant.images);
  baked.leaf_meshes = std::move(kept.meshes);
  baked.sphere = plant_sphere(foliage, plant.wood, baked.leaf_meshes);
  COPPICE_CHECK(move_into(baked.errors, measure_error_table(baked, stage_of(progress, "error table"))));
  if (!baked.leaf_meshes.parts.empty()) COPPICE_CHECK(move_into(baked.leaf_meshes.error_px, measure_leaf_mesh_error(baked)));
  report.seconds.error_table = watch.lap();
  baked.wind = wind_of({plant.wood, plant.foliage, plant.leaves, foliage.quads, baked.sphere}, options.wind);
  report.seconds.wind = watch.lap();

  progress("pack", 0.0);
  add_joints(baked.wind.head, plant.wood);
  COPPICE_CHECK(move_into(baked.wood, choose_wood_lods(baked, wood_levels(plant.wood))));
  drop_unused_materials(baked);
  COPPICE_TRY(bytes, pack(baked, report.sizes, options.textures));
  report.seconds.pack = watch.lap();
  report.seconds.total = total.lap();
  report.peak_rss_bytes = peak_rss_bytes();
  return bytes;
}

}  // namespace coppice::bake
