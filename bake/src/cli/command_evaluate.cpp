#include <CLI/CLI.hpp>
#include <memory>
#include <utility>

#include "class_arguments.h"
#include "commands.h"
#include "evaluate.h"
#include "import_arguments.h"
#include "limit_arguments.h"
#include "output.h"
#include "progress_bar.h"
#include "report.h"
#include "report_html.h"

namespace coppice::bake {
namespace {

struct EvaluateArguments {
  std::filesystem::path input, json, html;
  std::vector<std::string> methods;
  std::string reference = "quads";
  ClassArguments classes;
  ImportArguments import;
  LimitArguments limits;
  EvaluateOptions options;
};

/// Prints why an output cannot be written.
bool outputs_possible(const EvaluateArguments& arguments) {
  const std::pair<const std::filesystem::path&, const std::filesystem::path&> outputs[] = {{arguments.json, arguments.html},
                                                                                           {arguments.html, arguments.json}};
  for (const auto& [output, other] : outputs) {
    if (output.empty()) continue;
    if (const auto possible = check_output(output, {arguments.input, arguments.classes.classes, other}, Content::text); !possible) {
      report_failure(output, possible.error());
      return false;
    }
  }
  return true;
}

int run(const EvaluateArguments& arguments) {
  if (!outputs_possible(arguments)) return 1;
  if (arguments.import.all_variants)
    return report_failure(arguments.input, Error{Status::invalid_argument, "--variant all: evaluate takes one plant; give its number"});
  EvaluateOptions options = arguments.options;
  auto import = import_options(arguments.classes);
  if (!import) return report_failure(arguments.input, import.error());
  options.import = *std::move(import);
  options.reference = arguments.reference == "meshes" ? ReferenceKind::meshes : ReferenceKind::quads;
  apply_import_arguments(arguments.import, options.import);
  options.methods.clear();
  for (const std::string& name : arguments.methods) {
    const auto method = method_from_name(name);
    if (!method) return report_failure(arguments.input, method.error());
    options.methods.push_back(*method);
  }

  options.keep_pictures = !arguments.html.empty();

  ProgressBar bar(ProgressBar::Visibility::on_terminal);
  const auto report = evaluate(arguments.input, options, [&bar](const char* stage, double fraction) { bar.show(stage, fraction); });
  bar.clear();
  if (!report) return report_failure(arguments.input, report.error());
  print_warnings(arguments.input, report->warnings);

  const std::string json = evaluation_json(*report), table = evaluation_table(*report);
  const std::string html = arguments.html.empty() ? "" : evaluation_html(*report);
  return write_outputs({{arguments.json, bytes_of(json)}, {arguments.html, bytes_of(html)}}, table);
}

}  // namespace

void add_evaluate_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  std::vector<std::string> names;
  for (const Method method : all_methods()) names.emplace_back(method_name(method));
  arguments->methods = names;

  CLI::App* command = app.add_subcommand("evaluate", "Measure what simplifying does to a plant, against other methods");
  command->footer(
      "The reference is the plant's leaf quads, all of them, or with --reference meshes its leaves as they were modelled, textures "
      "included.\n"
      "24 cameras that no method has seen, 256 x 256 pixels, white background; rmse_64 and rmse_16 are of the same pictures box-filtered: "
      "what a distant viewer sees. Pictures of another size give errors named after theirs: rmse_512, rmse_128, rmse_32. Distances are "
      "shares of the box diagonal. The least error of a level is marked with *.\n"
      "  coppice evaluate willow.glb --methods default,geometric --levels .4,.1 --html willow.html\n"
      "  coppice evaluate willow.glb --methods default --levels 1,.4 --reference meshes --size 512");
  command->add_option("input", arguments->input, "The plant: .glb or .gltf")->required()->type_name("IN.glb");
  command->add_option("--methods", arguments->methods, "Simplifiers to compare")
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->type_name("A,B,...")
      ->capture_default_str();
  command->add_option("--levels", arguments->options.fractions, "Levels of detail, as fractions of the leaves; 1 is all of them")
      ->delimiter(',')
      ->check(CLI::Range(1e-9, 1.0))
      ->type_name("F,F,...")
      ->capture_default_str();
  command->add_option("--reference", arguments->reference, "Compare with the plant's leaf quads or with its leaf meshes")
      ->check(CLI::IsMember({"quads", "meshes"}))
      ->type_name("quads|meshes")
      ->capture_default_str();
  const CLI::Validator whole_steps(
      [](std::string& text) { return std::stoul(text) % kEvaluationSizeStepPx == 0 ? "" : "it must be a multiple of 16"; }, "",
      "multiple of 16");
  command->add_option("--size", arguments->options.size_px, "Side of the pictures in pixels, a multiple of 16")
      ->check(CLI::Range(kEvaluationSizeStepPx, kMaxEvaluationSizePx))
      ->check(whole_steps)
      ->type_name("PX")
      ->capture_default_str();
  add_output_option(*command, "--json", arguments->json, "Write the figures to this JSON file; - for the standard output")
      ->type_name("F.json");
  add_output_option(*command, "--html", arguments->html,
                    "Write a report with curves and pictures to this file; a browser opens it without a network")
      ->type_name("F.html");
  add_class_options(*command, arguments->classes);
  add_import_options(*command, arguments->import);
  add_plant_options(*command, arguments->import);
  command->add_option("--threads", arguments->options.thread_count, "Worker threads; 0 for all. The figures are the same for any number")
      ->check(CLI::Range(0, 1024))
      ->type_name("N")
      ->capture_default_str();
  add_limit_options(*command, arguments->limits);
  command->callback([arguments, exit_code] {
    *exit_code = run_limited(arguments->limits, arguments->input, {arguments->json, arguments->html}, [&] { return run(*arguments); });
  });
}

}  // namespace coppice::bake
