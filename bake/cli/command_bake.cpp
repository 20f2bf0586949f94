#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "bake_arguments.h"
#include "bounds.h"
#include "commands.h"
#include "dry_run.h"
#include "gltf_document.h"
#include "output.h"
#include "printable.h"
#include "progress_bar.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

struct BakeCommand {
  std::filesystem::path input, output, report, preview;
  BakeRequest bake;
  LimitArguments limits;
  bool dry_run = false, quiet = false;
};

double bytes_per_leaf(const BakeReport& report) {
  return report.source_leaves > 0 ? static_cast<double>(report.sizes.foliage_bytes) / report.source_leaves : 0.0;
}

std::string leaf_mesh_text(const BakeReport& report) {
  if (report.leaf_mesh_triangles == 0) return "no leaf meshes: " + report.leaf_mesh_note;
  return "leaf meshes " + readable_bytes(report.sizes.leaf_mesh_bytes) + ", " + std::to_string(report.leaf_mesh_triangles) + " triangles";
}

std::string area_text(const BakeReport& report) {
  if (report.area_device.empty()) return {};
  return std::string("; areas by occlusion queries ") + (report.area_every_step ? "at every step" : "before the first step");
}

nlohmann::ordered_json area_json(const BakeReport& report) {
  const bool queries = !report.area_device.empty();
  return {{"initial", queries ? "vulkan" : "item-buffers"},
          {"steps", report.area_every_step ? "vulkan" : "item-buffers"},
          {"device", report.area_device}};
}

nlohmann::ordered_json report_json(const BakeReport& report) {
  const auto& seconds = report.seconds;
  nlohmann::ordered_json levels = nlohmann::ordered_json::array();
  for (const FoliageInformation& level : report.level_information) levels.push_back({{"leaves", level.leaf_count}, {"bits", level.bits}});
  return {
      {"source_leaves", report.source_leaves},
      {"size_m", report.size_m},
      {"seconds",
       {{"import", seconds.import},
        {"visibility", seconds.visibility},
        {"collapse", seconds.collapse},
        {"error_table", seconds.error_table},
        {"wind", seconds.wind},
        {"pack", seconds.pack},
        {"total", seconds.total}}},
      {"peak_rss_bytes", report.peak_rss_bytes},
      {"file_bytes", report.sizes.file_bytes},
      {"foliage_bytes", report.sizes.foliage_bytes},
      {"bytes_per_leaf", bytes_per_leaf(report)},
      {"leaf_meshes",
       {{"bytes", report.sizes.leaf_mesh_bytes}, {"triangles", report.leaf_mesh_triangles}, {"none_because", report.leaf_mesh_note}}},
      {"areas", area_json(report)},
      {"evaluations", report.evaluations},
      {"foliage_mi", {{"source", report.source_information.bits}, {"levels", levels}}},
  };
}

Result<void> check_all_outputs(const BakeCommand& arguments, std::vector<std::filesystem::path> inputs) {
  inputs.push_back(arguments.bake.classes);
  return check_outputs({{arguments.output, Content::binary}, {arguments.report, Content::text}, {arguments.preview, Content::binary}},
                       inputs);
}

/// What the importer makes of the plant, as a table and a picture; nothing is baked.
int look(const BakeCommand& arguments, const ImportOptions& options) {
  const auto plant = import_gltf(arguments.input, options);
  if (!plant) return report_failure(arguments.input, plant.error());
  std::string table;
  if (arguments.dry_run && !arguments.quiet) {
    const auto contents = read_contents(arguments.input, options);
    if (!contents) return report_failure(arguments.input, contents.error());
    table = contents_table(*contents) + parts_table(*plant) + (contents->scenery.empty() ? "" : contents->scenery + "\n");
  }
  std::vector<std::uint8_t> png;
  if (!arguments.preview.empty()) {
    auto picture = render_leaf_preview_png(*plant);
    if (!picture) return report_failure(arguments.preview, picture.error());
    png = *std::move(picture);
  }
  if (const int failed = write_outputs({{arguments.preview, png}}, table); failed != 0 || !arguments.dry_run) return failed;
  print_warnings(arguments.input, plant->warnings);
  return 0;
}

int run_one(const BakeCommand& arguments) {
  const auto options = bake_options(arguments.bake);
  if (!options) return report_failure(arguments.input, options.error());
  if (arguments.dry_run || !arguments.preview.empty())
    if (const int failed = look(arguments, options->import); failed != 0 || arguments.dry_run) return failed;

  BakeReport report;
  ProgressBar bar(arguments.quiet ? ProgressBar::Visibility::never : ProgressBar::Visibility::on_terminal);
  const auto show = [&bar](const char* stage, double fraction) { bar.show(stage, fraction); };
  const auto bytes = bake(arguments.input, *options, show, report);
  bar.clear();
  if (!bytes) return report_failure(arguments.input, bytes.error());
  print_warnings(arguments.input, report.warnings);

  const std::string json = json_file(report_json(report));
  const std::string line =
      formatted("%s: %u leaves, %s, %s (foliage %.1f B/leaf; %s%s), %.1f s\n", shown(arguments.output).c_str(), report.source_leaves,
                size_text(report.size_m).c_str(), readable_bytes(report.sizes.file_bytes).c_str(), bytes_per_leaf(report),
                printable(leaf_mesh_text(report)).c_str(), area_text(report).c_str(), report.seconds.total);
  // A preview on the standard output has it to itself.
  const bool is_quiet = arguments.quiet || is_standard_output(arguments.preview);
  return write_outputs({{arguments.output, *bytes}, {arguments.report, bytes_of(json)}}, is_quiet ? "" : line);
}

/// The command for each variant of the input, with outputs of its own.
Result<std::vector<BakeCommand>> commands_of_variants(const BakeCommand& arguments) {
  for (const std::filesystem::path& output : {arguments.output, arguments.report, arguments.preview})
    COPPICE_CHECK(refuse_standard_output(output, "--variant all writes several files"));
  COPPICE_TRY(options, bake_options(arguments.bake));
  COPPICE_TRY(contents, read_contents(arguments.input, options.import));
  const auto outputs_like = [&contents](const std::filesystem::path& output) { return variant_outputs(output, contents); };
  std::vector<BakeCommand> commands(std::max<std::size_t>(contents.variants.size(), 1), arguments);
  for (std::size_t i = 0; i < commands.size(); ++i) {
    commands[i].bake.options.import.plant.variant = static_cast<std::uint32_t>(i + 1);
    for (const auto path : {&BakeCommand::output, &BakeCommand::report, &BakeCommand::preview})
      if (!(arguments.*path).empty()) commands[i].*path = outputs_like(arguments.*path)[i];
  }
  return commands;
}

int run(const BakeCommand& arguments) {
  std::vector<BakeCommand> commands{arguments};
  if (arguments.bake.all_variants) {
    auto all = commands_of_variants(arguments);
    if (!all) return report_failure(arguments.input, all.error());
    commands = *std::move(all);
  }
  const std::vector<std::filesystem::path> inputs = files_of_gltf(arguments.input);
  for (const BakeCommand& command : commands)
    if (const auto possible = check_all_outputs(command, inputs); !possible) return report_failure({}, possible.error());
  int exit_code = 0;
  for (const BakeCommand& command : commands) exit_code = std::max(exit_code, run_one(command));
  return exit_code;
}

}  // namespace

void add_bake_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<BakeCommand>();
  CLI::App* command = app.add_subcommand("bake", "Turn a glTF plant into a .coppice file: every level of detail in one stream");
  command->footer(
      "Leaves are found by material name, alpha mask, shape, repetition and colour; everything else is wood.\n"
      "  coppice bake poplar.glb --dry-run --preview parts.png   what was found and why, nothing is baked\n"
      "  coppice bake poplar.glb -o poplar.coppice --leaf-material '^Leaves$'");
  command->add_option("input", arguments->input, "The plant: .glb or .gltf")->required()->type_name("IN.glb|IN.gltf");
  CLI::Option* output = add_output_option(*command, "-o,--output", arguments->output,
                                          "The .coppice file to write, which appears whole or not at all; - for the standard output");
  output->type_name("OUT.coppice");
  CLI::Option* dry_run = command->add_flag(
      "--dry-run", arguments->dry_run, "Print what each material's pieces are taken for and why; bake nothing and write no .coppice file");
  add_bake_options(*command, arguments->bake);
  add_count_option(*command, "--threads", arguments->bake.options.thread_count,
                   "Worker threads; 0 for all. The result is the same for any number");
  add_limit_options(*command, arguments->limits);
  add_output_option(*command, "--report", arguments->report, "Write times, sizes and foliage information to this JSON file")
      ->type_name("F.json");
  add_output_option(*command, "--preview", arguments->preview, "Draw the plant with every leaf in a green of its own and wood in brown")
      ->type_name("F.png");
  command->add_flag("--quiet", arguments->quiet, "Print nothing but warnings and errors");
  command->callback([arguments, output, dry_run, exit_code] {
    if (output->count() == 0 && dry_run->count() == 0) throw CLI::RequiredError("--output or --dry-run");
    check_bake_request(arguments->bake);
    *exit_code = run_limited(arguments->limits, arguments->input, {arguments->output, arguments->report, arguments->preview},
                             [&] { return run(*arguments); });
  });
}

}  // namespace coppice::bake
