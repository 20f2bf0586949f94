#include "bake_arguments.h"

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "raster.h"
#include "text_number.h"

namespace coppice::bake {

namespace {

/// n of COLOR_n.
std::uint32_t color_set(std::string_view name) {
  constexpr std::string_view kPrefix = "COLOR_";
  const auto set = number_of<std::uint32_t>(name.starts_with(kPrefix) ? name.substr(kPrefix.size()) : std::string_view());
  if (!set) throw CLI::ValidationError("--wind-weights", "not a set of vertex colours, COLOR_0, COLOR_1 and so on: " + std::string(name));
  return *set;
}

}  // namespace

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
              std::to_string(kMaxMeasuredLeaves) + " leaves and only before the first for more. Another driver may then give another file")
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
  command
      .add_option("--wind-stiffness", options.wind.stiffness,
                  "How stiff the plant is in wind, against what its wood tells: 2 moves half as far, 0.5 twice as far where limits let it")
      ->check(CLI::Range(kMinWindStiffness, kMaxWindStiffness))
      ->type_name("FACTOR")
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--wind-weights", [&options](const std::string& name) { options.import.wind_color_set = color_set(name); },
          "The vertex colours whose red says how flexible a place is, from 0, stiff, to 1; they are then no tint. Without it an attribute "
          "_WIND_WEIGHT or _WIND does")
      ->type_name("COLOR_N");
  command.add_flag("--no-wind", arguments.no_wind, "Wind does not move the plant");
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
  options.wind.moves = !arguments.no_wind;
  COPPICE_TRY(import, import_options(arguments.classes));
  import.wind_color_set = options.import.wind_color_set;
  options.import = std::move(import);
  apply_import_arguments(arguments.import, options.import);
  return options;
}

}  // namespace coppice::bake
