#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "bake_arguments.h"
#include "bake_batch.h"
#include "bake_cache.h"
#include "commands.h"
#include "gltf_document.h"
#include "output.h"
#include "progress_bar.h"
#include "sibling_program.h"

namespace coppice::bake {
namespace {

constexpr const char* kViewer = "coppice-forest";

struct ViewArguments {
  std::filesystem::path input;
  BakeRequest bake;
  std::vector<std::string> viewer;  ///< words for coppice-forest
  std::string camera, screenshot;
  bool headless = false;
};

/// $XDG_CACHE_HOME/coppice, or ~/.cache/coppice, as the XDG base directory specification has it.
Result<std::filesystem::path> cache_folder() {
  for (const auto& [variable, below] : {std::pair{"XDG_CACHE_HOME", "coppice"}, std::pair{"HOME", ".cache/coppice"}}) {
    const char* folder = std::getenv(variable);
    if (folder != nullptr && std::filesystem::path(folder).is_absolute()) return std::filesystem::path(folder) / below;
  }
  return Error{Status::invalid_argument, "no folder for baked plants: neither XDG_CACHE_HOME nor HOME is set"};
}

/// The baked plant: the input itself, or what the cache has of it.
Result<std::filesystem::path> baked(const ViewArguments& arguments) {
  if (!is_plant_file(arguments.input)) return arguments.input;
  COPPICE_TRY(cache, cache_folder());
  COPPICE_TRY(options, bake_options(arguments.bake));
  ProgressBar bar(ProgressBar::Visibility::on_terminal);
  const BatchResult result = bake_cached({arguments.input, {}, std::move(options)}, cache,
                                         [&bar](const char* stage, double fraction) { bar.show(stage, fraction); });
  bar.clear();
  if (result.outcome == BatchOutcome::failed) return Error{Status::internal, "not baked", Error::kNoOffset, result.error};
  print_warnings(arguments.input, result.warnings);
  const std::filesystem::path file = cached_file(cache, result.key);
  std::printf("%s: %s as %s, %u leaves, %.1f s\n", shown(arguments.input).c_str(), outcome_name(result.outcome), shown(file).c_str(),
              result.source_leaves, result.seconds);
  return file;
}

int run(const ViewArguments& arguments) {
  if (arguments.bake.all_variants)
    return report_failure(arguments.input,
                          Error{Status::invalid_argument, "one plant is shown at a time: --variant takes a number here, not all"});
  const auto possible = check_outputs({{arguments.screenshot, Content::binary}}, files_of_gltf(arguments.input));
  if (!possible) return report_failure({}, possible.error());
  const auto viewer = find_program(kViewer);
  if (!viewer) return report_failure(arguments.input, viewer.error());
  const auto plant = baked(arguments);
  if (!plant) return report_failure(arguments.input, plant.error());
  std::vector<std::string> words{plant->string()};
  if (!arguments.camera.empty()) words.insert(words.end(), {"--camera", arguments.camera});
  if (!arguments.screenshot.empty()) words.insert(words.end(), {"--screenshot", arguments.screenshot});
  if (arguments.headless) words.emplace_back("--headless");
  words.insert(words.end(), arguments.viewer.begin(), arguments.viewer.end());
  return report_failure(arguments.input, start_program(*viewer, std::move(words)));
}

}  // namespace

void add_view_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<ViewArguments>();
  CLI::App* command = app.add_subcommand("view", "Bake a plant, unless that has been done, and look at it");
  command->footer(
      "Baked plants are kept in $XDG_CACHE_HOME/coppice (~/.cache/coppice), which may be deleted at any time. They are shown by "
      "coppice-forest, which is looked for beside this program and on PATH; what follows -- are options of that.\n"
      "  coppice view oak.glb\n"
      "  coppice view oak.glb -- --wind 12\n"
      "  coppice view oak.glb --camera front --headless --screenshot oak.png -- --size 800x800");
  command->add_option("input", arguments->input, "The plant: .glb, .gltf or .coppice")->required()->type_name("IN.glb|IN.gltf|IN.coppice");
  command->add_option("forest-options", arguments->viewer, "After --: options of coppice-forest")->type_name("");
  command
      ->add_option("--camera", arguments->camera,
                   "As of coppice-forest: round the plant, before it, above it, or along keyframes of a file")
      ->type_name("turntable|front|top|FILE");
  command->add_flag("--headless", arguments->headless, "No window: with --screenshot");
  command->add_option("--screenshot", arguments->screenshot, "Write the last frame, once streaming has settled")->type_name("F.png");
  add_bake_options(*command, arguments->bake);
  command->callback([arguments, exit_code] {
    check_bake_request(arguments->bake);
    *exit_code = run(*arguments);
  });
}

}  // namespace coppice::bake
