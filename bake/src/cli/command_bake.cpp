#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "atomic_file.h"
#include "bake_arguments.h"
#include "commands.h"
#include "progress_bar.h"

namespace coppice::bake {
namespace {

struct BakeCommand {
  std::filesystem::path input, output, report;
  BakeArguments bake;
  bool quiet = false;
};

nlohmann::ordered_json report_json(const BakeReport& report) {
  const auto& seconds = report.seconds;
  nlohmann::ordered_json levels = nlohmann::ordered_json::array();
  for (const FoliageInformation& level : report.level_information) levels.push_back({{"leaves", level.leaf_count}, {"bits", level.bits}});
  return {
      {"source_leaves", report.source_leaves},
      {"seconds",
       {{"import", seconds.import},
        {"visibility", seconds.visibility},
        {"collapse", seconds.collapse},
        {"error_table", seconds.error_table},
        {"pack", seconds.pack},
        {"total", seconds.total}}},
      {"peak_rss_bytes", report.peak_rss_bytes},
      {"file_bytes", report.sizes.file_bytes},
      {"foliage_bytes", report.sizes.foliage_bytes},
      {"bytes_per_leaf", static_cast<double>(report.sizes.foliage_bytes) / report.source_leaves},
      {"evaluations", report.evaluations},
      {"foliage_mi", {{"source", report.source_information.bits}, {"levels", levels}}},
  };
}

int run(const BakeCommand& arguments) {
  for (const auto& [output, others] : {std::pair{arguments.output, std::vector{arguments.input, arguments.report}},
                                       std::pair{arguments.report, std::vector{arguments.input, arguments.output}}})
    if (const auto possible = check_output(output, others); !output.empty() && !possible) return report_failure(output, possible.error());

  BakeReport report;
  ProgressBar bar(arguments.quiet ? ProgressBar::Visibility::never : ProgressBar::Visibility::on_terminal);
  const auto bytes = bake(
      arguments.input, bake_options(arguments.bake), [&bar](const char* stage, double fraction) { bar.show(stage, fraction); }, report);
  bar.clear();
  if (!bytes) return report_failure(arguments.input, bytes.error());
  for (const std::string& warning : report.warnings)
    std::fprintf(stderr, "coppice: warning: %s: %s\n", arguments.input.c_str(), warning.c_str());

  if (const auto written = write_file_atomically(arguments.output, *bytes); !written)
    return report_failure(arguments.output, written.error());
  if (!arguments.report.empty()) {
    const std::string json = report_json(report).dump(2) + "\n";
    const auto written = write_file_atomically(arguments.report, {reinterpret_cast<const std::uint8_t*>(json.data()), json.size()});
    if (!written) return report_failure(arguments.report, written.error());
  }
  if (!arguments.quiet)
    std::printf("%s: %u leaves, %s (foliage %.1f B/leaf), %.1f s\n", arguments.output.c_str(), report.source_leaves,
                readable_bytes(report.sizes.file_bytes).c_str(), static_cast<double>(report.sizes.foliage_bytes) / report.source_leaves,
                report.seconds.total);
  return 0;
}

}  // namespace

void add_bake_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<BakeCommand>();
  CLI::App* command = app.add_subcommand("bake", "Turn a glTF plant into a .coppice file: every level of detail in one stream");
  command->footer(
      "Leaves are the connected pieces of the materials whose name says so (leaf, leaves, foliage, needle ... in several languages); "
      "everything else is wood.\n--leaf-material names them yourself:\n"
      "  coppice bake poplar.glb -o poplar.coppice --leaf-material '^Leaves$'");
  command->add_option("input", arguments->input, "The plant: .glb or .gltf")->required()->type_name("IN.glb");
  command->add_option("-o,--output", arguments->output, "The .coppice file to write; appears whole or not at all")
      ->required()
      ->type_name("OUT.coppice");
  add_bake_options(*command, arguments->bake);
  command->add_option("--threads", arguments->bake.options.thread_count, "Worker threads; 0 for all. The result is the same for any number")
      ->check(CLI::Range(0, 1024))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--report", arguments->report, "Write times, sizes and foliage information to this JSON file")->type_name("F.json");
  command->add_flag("--quiet", arguments->quiet, "Print nothing but warnings and errors");
  command->callback([arguments, exit_code] { *exit_code = run(*arguments); });
}

}  // namespace coppice::bake
