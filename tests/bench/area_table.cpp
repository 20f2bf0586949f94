// How far occlusion queries and item buffers are apart, as a table: area_table PLANT...
// PLANT is a species of `coppice plant`, or FILE.glb. Of each: how areas differ at the start; and what the collapse by mutual information
// makes of either, as `coppice bake --metric mi` and `--areas vulkan` do: I(V,L) and the errors of cuts at .8 .6 .4 .2 .1 .05 .025.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "bake.h"
#include "collapse_information.h"
#include "generate_plant.h"
#include "held_out_error.h"
#include "import_gltf.h"
#include "item_areas.h"
#include "leaf_cards.h"
#include "occlusion_areas.h"
#include "stopwatch.h"
#include "tree_order.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

Result<Plant> load(const std::string& name) {
  return name.ends_with(".glb") ? import_gltf(name, {}) : generate_plant(name, 1);
}

void print_differences(const std::vector<std::uint32_t>& queries, const ItemBuffers& buffers) {
  const std::vector<std::uint32_t> fronts = leaf_areas_px(buffers);
  const std::vector<std::uint32_t> behind = background_areas_px(buffers);
  double differences = 0.0, total = 0.0, query_total = 0.0, background = 0.0, query_background = 0.0;
  std::uint32_t largest = 0;
  for (std::size_t v = 0; v < buffers.view_count; ++v) {
    for (std::size_t leaf = 0; leaf < buffers.leaf_count; ++leaf) {
      const std::uint32_t a = fronts[v * buffers.leaf_count + leaf], b = queries[leaf * buffers.view_count + v];
      const std::uint32_t difference = a > b ? a - b : b - a;
      differences += difference;
      largest = std::max(largest, difference);
      total += a;
      query_total += b;
    }
    const double query_behind = queries[buffers.leaf_count * buffers.view_count + v];
    background += std::abs(static_cast<double>(behind[v]) - query_behind);
    query_background += query_behind;
  }
  // A pixel without a leaf is background; every leaf above one of the others is a tie.
  const double ties = query_total + query_background - static_cast<double>(buffers.view_count) * buffers.pixels_per_view();
  std::printf("  areas: sum of differences %.4f %%, of the total %.4f %%, largest %u px, background %.4f %% of the foliage, %.0f ties\n",
              100.0 * differences / total, 100.0 * (query_total - total) / total, largest, 100.0 * background / total, ties);
  std::fflush(stdout);
}

struct Shown {
  const Foliage& foliage;
  const test::HeldOutViews& reference;
};

int print_collapse(const char* name, const Shown& shown, const Result<CollapseResult>& result, double seconds) {
  if (!result) return std::fprintf(stderr, "%s\n", result.error().message().c_str()), 1;
  std::printf("  %-12s %6.1f s, I %.5f", name, seconds, result->source.bits);
  const Tree tree = build_tree(shown.foliage, result->sequence);
  for (const FoliageInformation& level : result->levels) {
    const test::HeldOutErrors errors = shown.reference.errors_of(cut_foliage(tree, shown.foliage.card_table, level.leaf_count));
    std::printf(" | %.4f %.1f %.1f", level.bits, errors.rmse_256, errors.rmse_16);
  }
  std::printf("\n");
  std::fflush(stdout);
  return 0;
}

int print_plant(const std::string& name) {
  auto plant = load(name);
  if (!plant) return std::fprintf(stderr, "%s\n", plant.error().message().c_str()), 1;
  const auto foliage = card_foliage(*plant);
  if (!foliage) return std::fprintf(stderr, "%s\n", foliage.error().message().c_str()), 1;
  const ShownFoliage shown{*foliage, plant->materials, plant->images};
  const std::vector<Viewpoint> views = *viewpoints(20);
  const CollapseOptions options;
  const auto queries = OcclusionAreas::create({shown, views, options.resolution_px});
  if (!queries) return std::fprintf(stderr, "%s\n", queries.error().message().c_str()), 1;

  test::Stopwatch watch;
  const auto buffers = render_item_buffers(shown, views, options.resolution_px);
  const double buffer_seconds = watch.seconds();
  watch = {};
  std::vector<std::uint32_t> areas_px((std::size_t{foliage->leaf_count()} + 1) * views.size());
  if (const auto done = (*queries)->measure({foliage->quads, foliage->cards, {}}, areas_px, {}); !done)
    return std::fprintf(stderr, "%s\n", done.error().message().c_str()), 1;
  std::printf("%s, %u leaves, on %s\n  %.2f s for item buffers, %.2f s for queries\n", name.substr(name.rfind('/') + 1).c_str(),
              foliage->leaf_count(), (*queries)->device_name().c_str(), buffer_seconds, watch.seconds());
  print_differences(areas_px, *buffers);

  const test::HeldOutViews reference(*foliage, *plant);
  const MeasureAreas measure = [&](const AreaRequest& request, std::span<std::uint32_t> areas) {
    return (*queries)->measure(request, areas, {});
  };
  std::vector<std::pair<const char*, AreaSource>> sources{{"item buffers", {}}, {"initial", {measure, false}}};
  if (foliage->leaf_count() <= kMaxMeasuredLeaves) sources.push_back({"every step", {measure, true}});
  for (const auto& [source_name, source] : sources) {
    watch = {};
    const auto result = collapse_by_mutual_information(shown, views, options, {}, source);
    if (const int failed = print_collapse(source_name, {*foliage, reference}, result, watch.seconds()); failed != 0) return failed;
  }
  return 0;
}

}  // namespace
}  // namespace coppice::bake

int main(int argument_count, char** arguments) {
  if (argument_count < 2) return std::fprintf(stderr, "usage: area_table PLANT...\n"), 2;
  for (int i = 1; i < argument_count; ++i)
    if (const int failed = coppice::bake::print_plant(arguments[i]); failed != 0) return failed;
  return 0;
}
