#include "bake_arguments.h"

#include <CLI/CLI.hpp>
#include <string>
#include <utility>

#include "raster.h"

namespace coppice::bake {

void add_bake_options(CLI::App& command, BakeArguments& arguments) {
  BakeOptions& options = arguments.options;
  command
      .add_option("--metric", arguments.metric,
                  "What orders the collapses: default is the least error of the picture, which measures best; mi is the paper's viewpoint "
                  "mutual information; geometric merges what is nearest and most alike, for comparison")
      ->check(CLI::IsMember({"default", "mi", "geometric"}))
      ->type_name("default|mi|geometric")
      ->capture_default_str();
  command
      .add_option("--views", options.view_count,
                  "Viewpoints; 20 is the paper's dodecahedron. By default 20; 42 for the default metric, 32 of it for over 8,192 leaves")
      ->check(CLI::Range(1u, kMaxViewCount))
      ->type_name("N");
  command.add_option("--resolution", options.collapse.resolution_px, "Side of an item buffer in pixels")
      ->check(CLI::Range(16u, kMaxResolutionPx))
      ->type_name("PX")
      ->capture_default_str();
  command.add_option("--background", arguments.background, "Count the background as one more outcome")
      ->check(CLI::IsMember({"on", "off"}))
      ->type_name("on|off")
      ->capture_default_str();
  command
      .add_option("--candidates", options.collapse.candidate_count,
                  "The octree cell of candidates grows until it holds so many. The default metric looks at up to four times as many where "
                  "what it merges no longer covers the crown")
      ->check(CLI::Range(1u, kMaxCandidateCount))
      ->type_name("N")
      ->capture_default_str();
  command.add_flag("--quick", arguments.quick,
                   "About ten times faster, for a first look: fewer and smaller views, fewer candidates, where --views, --resolution and "
                   "--candidates do not say otherwise. The picture's error grows by about 5 %, of plants a few pixels large by a fifth");
  command
      .add_option(
          "--areas", arguments.areas,
          "Who measures the projected areas of --metric mi: item-buffers, or the paper's occlusion queries on a Vulkan device, at every "
          "step for up to " +
              std::to_string(kMostMeasuredLeaves) + " leaves and only before the first for more. Another driver may then give another file")
      ->check(CLI::IsMember({"item-buffers", "vulkan"}))
      ->type_name("item-buffers|vulkan")
      ->capture_default_str();
  command
      .add_option(
          "--textures", arguments.textures,
          "How textures are stored: bc is BC1 and BC3 blocks, which a GPU reads as they are; rgba8 takes four to eight times the bytes")
      ->check(CLI::IsMember({"bc", "rgba8"}))
      ->type_name("bc|rgba8")
      ->capture_default_str();
  command
      .add_option("--crown-normals", options.crown_normals,
                  "How leaves are lit: 0 each by its own normal, 1 by that of the crown's round shape there, which is softer")
      ->check(CLI::Range(0.0f, 1.0f))
      ->type_name("SHARE")
      ->capture_default_str();
  command
      .add_option("--leaf-meshes", arguments.leaf_meshes,
                  "Keep the leaves as they were modelled, to be drawn close up, where the error of their quads would be seen")
      ->check(CLI::IsMember({"on", "off"}))
      ->type_name("on|off")
      ->capture_default_str();
  add_class_options(command, arguments.classes);
  add_import_options(command, arguments.import);
  add_plant_options(command, arguments.import);
}

void check_bake_arguments(const BakeArguments& arguments) {
  if (arguments.areas == "vulkan" && arguments.metric != "mi") throw CLI::ValidationError("--areas", kAreasNeedMi);
}

Result<BakeOptions> bake_options(const BakeArguments& arguments) {
  BakeOptions options = arguments.options;
  const BakeOptions defaults;
  if (arguments.quick && options.view_count == defaults.view_count) options.view_count = kQuickViewCount;
  if (arguments.quick && options.collapse.resolution_px == defaults.collapse.resolution_px)
    options.collapse.resolution_px = kQuickResolution_px;
  if (arguments.quick && options.collapse.candidate_count == defaults.collapse.candidate_count)
    options.collapse.candidate_count = kQuickCandidateCount;
  options.metric = arguments.metric == "mi" ? Metric::mi : arguments.metric == "geometric" ? Metric::geometric : Metric::default_metric;
  options.collapse.count_background = arguments.background == "on";
  options.textures = arguments.textures == "rgba8" ? TextureCoding::rgba8 : TextureCoding::bc;
  options.leaf_meshes = arguments.leaf_meshes == "on";
  options.areas = arguments.areas == "vulkan" ? Areas::vulkan : Areas::item_buffers;
  COPPICE_CHECK(check_areas(options));
  COPPICE_TRY(import, import_options(arguments.classes));
  options.import = std::move(import);
  apply_import_arguments(arguments.import, options.import);
  return options;
}

}  // namespace coppice::bake
