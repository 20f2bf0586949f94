// coppice-lab: the program that `coppice evaluate` becomes. To the user the two are one: its help and its messages say `coppice`.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <utility>

#include "bake_arguments.h"
#include "evaluate.h"
#include "evaluate_command.h"
#include "generate_plant.h"
#include "gltf_document.h"
#include "gltf_write.h"
#include "import_gltf.h"
#include "material_split.h"
#include "output.h"
#include "program.h"
#include "progress_bar.h"
#include "report.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

struct EvaluateArguments {
  std::filesystem::path input, json, html, source;
  std::vector<std::string> methods, level_sets;
  std::string reference = "quads";
  bool paper = false;
  BakeRequest bake;
  LimitArguments limits;
  EvaluateOptions options;
};

/// A plant to measure, and where its pages go.
struct Subject {
  std::string species;  ///< one that `coppice plant` grows; empty: the input file
  std::filesystem::path html;
};

/// report.html of willow is report_willow.html.
std::filesystem::path html_of(const std::filesystem::path& html, const std::string& species) {
  if (html.empty() || is_standard_output(html)) return html;
  return html.parent_path() / (html.stem().string() + "_" + species + html.extension().string());
}

std::vector<Subject> subjects(const EvaluateArguments& arguments) {
  if (!arguments.input.empty()) return {{"", arguments.html}};
  std::vector<Subject> all;
  for (const char* species : {"corylus", "willow", "juniper"}) all.push_back({species, html_of(arguments.html, species)});
  return all;
}

std::vector<std::filesystem::path> output_paths(const EvaluateArguments& arguments) {
  std::vector<std::filesystem::path> paths{arguments.json, arguments.source};
  for (const Subject& subject : subjects(arguments)) paths.push_back(subject.html);
  return paths;
}

Result<void> check_all_outputs(const EvaluateArguments& arguments) {
  std::vector<std::pair<std::filesystem::path, Content>> outputs;
  for (const std::filesystem::path& output : output_paths(arguments))
    outputs.emplace_back(output, output == arguments.source ? Content::binary : Content::text);
  std::vector<std::filesystem::path> inputs = files_of_gltf(arguments.input);
  inputs.push_back(arguments.bake.classes);
  return check_outputs(outputs, inputs);
}

Result<std::vector<Method>> methods_of(const EvaluateArguments& arguments) {
  std::vector<Method> methods;
  for (const std::string& name : arguments.methods) {
    if (name == "all") return std::vector<Method>(all_methods().begin(), all_methods().end());
    COPPICE_TRY(method, method_from_name(name));
    methods.push_back(method);
  }
  if (!methods.empty()) return methods;
  if (arguments.paper) return std::vector<Method>{Method::mi, Method::geometric};
  return std::vector<Method>(default_methods().begin(), default_methods().end());
}

/// NAME=FOLDER, each name once.
Result<std::vector<LevelSet>> level_sets_of(const EvaluateArguments& arguments) {
  std::vector<LevelSet> sets;
  for (const std::string& text : arguments.level_sets) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
      return Error{Status::invalid_argument, "--levels-of wants NAME=FOLDER", Error::kNoOffset, text};
    LevelSet set{text.substr(0, equals), text.substr(equals + 1)};
    const bool is_taken = std::ranges::any_of(sets, [&](const LevelSet& other) { return other.name == set.name; });
    if (is_taken || method_from_name(set.name))
      return Error{Status::invalid_argument, "--levels-of: the name is taken", Error::kNoOffset, set.name};
    sets.push_back(std::move(set));
  }
  return sets;
}

Result<EvaluateOptions> options_of(const EvaluateArguments& arguments) {
  EvaluateOptions options = arguments.options;
  COPPICE_TRY(bake, bake_options(arguments.bake));
  options.import = std::move(bake.import);
  options.reference = arguments.reference == "meshes" ? ReferenceKind::meshes : ReferenceKind::quads;
  options.setup = arguments.paper ? Setup::paper : Setup::ours;
  COPPICE_TRY(methods, methods_of(arguments));
  options.methods = std::move(methods);
  COPPICE_TRY(level_sets, level_sets_of(arguments));
  options.level_sets = std::move(level_sets);
  options.keep_pictures = !arguments.html.empty();
  return options;
}

Result<EvaluationReport> evaluate_subject(const EvaluateArguments& arguments, const Subject& subject, const EvaluateOptions& options) {
  ProgressBar bar(ProgressBar::Visibility::on_terminal);
  const auto show = [&bar](const char* stage, double fraction) { bar.show(stage, fraction); };
  constexpr std::uint64_t kSeed = 1;
  auto report = [&]() -> Result<EvaluationReport> {
    if (subject.species.empty()) return evaluate(arguments.input, options, show);
    COPPICE_TRY(plant, generate_plant(subject.species, kSeed));
    return evaluate_plant(std::move(plant), options, show);
  }();
  bar.clear();
  return report;
}

/// The leaf quads that simplifiers get, as a file for other tools: their levels come back with --levels-of.
int write_source(const EvaluateArguments& arguments, const EvaluateOptions& options) {
  auto plant = import_gltf(arguments.input, options.import);
  if (!plant) return report_failure(arguments.input, plant.error());
  split_materials(*plant);
  const auto foliage = source_foliage(*plant, options.setup);
  if (!foliage) return report_failure(arguments.input, foliage.error());
  const Mesh mesh = foliage_mesh(*foliage);
  const auto bytes = encode_glb({{"leaves", &mesh}}, plant->materials, plant->images);
  if (!bytes) return report_failure(arguments.source, bytes.error());
  return write_outputs({{arguments.source, *bytes}}, formatted("%s: %u leaves\n", shown(arguments.source).c_str(), foliage->leaf_count()));
}

int run(const EvaluateArguments& arguments) {
  if (const auto possible = check_all_outputs(arguments); !possible) return report_failure({}, possible.error());
  if (arguments.bake.all_variants)
    return report_failure(arguments.input, Error{Status::invalid_argument, "--variant all: evaluate takes one plant; give its number"});
  const auto options = options_of(arguments);
  if (!options) return report_failure(arguments.input, options.error());
  if (!arguments.source.empty()) return write_source(arguments, *options);

  std::vector<EvaluationReport> reports;
  std::vector<std::string> pages;
  std::string table;
  for (const Subject& subject : subjects(arguments)) {
    const std::filesystem::path name = subject.species.empty() ? arguments.input : std::filesystem::path(subject.species);
    auto report = evaluate_subject(arguments, subject, *options);
    if (!report) return report_failure(name, report.error());
    print_warnings(name, report->warnings);
    table += (table.empty() ? "" : "\n") + evaluation_table(*report);
    pages.push_back(subject.html.empty() ? "" : evaluation_html(*report));
    reports.push_back(*std::move(report));
  }
  const std::string json = arguments.input.empty() ? evaluations_json(reports) : evaluation_json(reports.front());
  const std::vector<Subject> all = subjects(arguments);
  std::vector<Output> outputs{{arguments.json, bytes_of(json)}};
  for (std::size_t i = 0; i < all.size(); ++i) outputs.push_back({all[i].html, bytes_of(pages[i])});
  return write_outputs(outputs, table);
}

/// --methods, --levels-of and --levels.
void add_method_options(CLI::App& command, EvaluateArguments& arguments) {
  std::vector<std::string> names{"all"};
  std::string default_names, others;
  for (const Method method : all_methods()) {
    names.emplace_back(method_name(method));
    const bool is_default = std::ranges::find(default_methods(), method) != default_methods().end();
    std::string& list = is_default ? default_names : others;
    list += (list.empty() ? "" : ",") + names.back();
  }
  command
      .add_option("--methods", arguments.methods,
                  "Simplifiers to compare; without, " + default_names + ". Others, each with its best parameters: " + others + "; or all")
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->type_name("A,B,...");
  command
      .add_option(
          "--levels-of", arguments.level_sets,
          "Measure levels that another tool wrote, called NAME: glTF files FOLDER/0.8.glb and so on, named after --levels; or folders of "
          "such files, of which the best counts. May be given again")
      ->type_name("NAME=FOLDER");
  command.add_option("--levels", arguments.options.fractions, "Levels of detail, as fractions of the leaves; 1 is all of them")
      ->delimiter(',')
      ->check(CLI::Range(1e-9, 1.0))
      ->type_name("F,F,...")
      ->capture_default_str();
}

/// What the pictures are of.
void add_picture_options(CLI::App& command, EvaluateArguments& arguments) {
  CLI::Option* reference =
      command.add_option("--reference", arguments.reference, "Compare with the plant's leaf quads or with its leaf meshes")
          ->check(CLI::IsMember({"quads", "meshes"}))
          ->type_name("quads|meshes")
          ->capture_default_str();
  command
      .add_flag(
          "--paper", arguments.paper,
          "The paper's set-up and nothing of ours: leaves are rectangles of its equation (1), opaque and of one colour; methods mi and "
          "geometric; mi looks in perspective, from --view-distance. Without IN.glb its three plants, as `coppice plant` grows them")
      ->excludes(reference);
  command
      .add_option("--view-distance", arguments.options.view_distance_radii,
                  "How far cameras are from the middle of the leaves' bounding sphere, in its radii; the sphere always fills the picture")
      ->check(CLI::Range(1.01, kMaxViewDistanceRadii))
      ->type_name("RADII")
      ->capture_default_str();
  const CLI::Validator whole_steps(
      [](std::string& text) { return std::stoul(text) % kEvaluationSizeStepPx == 0 ? "" : "it must be a multiple of 16"; }, "",
      "multiple of 16");
  command.add_option("--size", arguments.options.size_px, "Side of the pictures in pixels, a multiple of 16")
      ->check(CLI::Range(kEvaluationSizeStepPx, kMaxEvaluationSizePx))
      ->check(whole_steps)
      ->type_name("PX")
      ->capture_default_str();
}

void add_outputs(CLI::App& command, EvaluateArguments& arguments) {
  add_output_option(command, "--json", arguments.json, "Write the figures to this JSON file; - for the standard output")
      ->type_name("F.json");
  add_output_option(
      command, "--html", arguments.html,
      "Write a report with curves and pictures to this file; a browser opens it without a network. Of three plants F_corylus.html "
      "and so on")
      ->type_name("F.html");
  add_output_option(command, "--write-source", arguments.source,
                    "Measure nothing; write the leaf quads that simplifiers get, for another tool to simplify: see --levels-of")
      ->type_name("F.glb");
}

/// Adds the options of `coppice evaluate`. Its callback evaluates, and leaves the exit code in *exit_code.
void declare_evaluate(CLI::App& command, int* exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  command.footer(
      "The reference is the plant's leaf quads, all of them, or with --reference meshes its leaves as they were modelled, textures "
      "included.\n"
      "24 cameras that no method has seen, 256 x 256 pixels, white background; rmse_64 and rmse_16 are of the same pictures box-filtered: "
      "what a distant viewer sees. Pictures of another size give errors named after theirs: rmse_512, rmse_128, rmse_32. mean, worst: "
      "of six errors, leaves lit on one side or shining through before grounds of luminance 0, 0.3 and 1; luminance: that of leaves over "
      "the source's. suns: the same "
      "cameras lit from eight directions; frames: the mean of 16 frames as temporal antialiasing shows it. Distances are "
      "shares of the box diagonal. The least error of a level is marked with *.\n"
      "  coppice evaluate willow.glb --methods default,geometric --levels .4,.1 --html willow.html\n"
      "  coppice evaluate willow.glb --methods default --levels 1,.4 --reference meshes --size 512\n"
      "  coppice evaluate --paper --json paper.json\n"
      "Another tool is measured by what it makes of the leaf quads, here as mine/0.4.glb and mine/0.1.glb.\n"
      "  coppice evaluate willow.glb --write-source quads.glb\n"
      "  coppice evaluate willow.glb --methods default --levels .4,.1 --levels-of mine=mine");
  command.add_option("input", arguments->input, "The plant: .glb or .gltf; not needed with --paper")->type_name("IN.glb|IN.gltf");
  add_method_options(command, *arguments);
  add_picture_options(command, *arguments);
  add_outputs(command, *arguments);
  add_bake_options(command, arguments->bake, {OptionGroup::classes, OptionGroup::units, OptionGroup::plant});
  add_count_option(command, "--threads", arguments->options.thread_count,
                   "Worker threads; 0 for all. The figures are the same for any number");
  add_limit_options(command, arguments->limits);
  command.callback([arguments, exit_code] {
    if (arguments->input.empty() && (!arguments->paper || !arguments->source.empty() || !arguments->level_sets.empty()))
      throw CLI::RequiredError("input");
    *exit_code = run_limited(arguments->limits, arguments->input, output_paths(*arguments), [&] { return run(*arguments); });
  });
}

}  // namespace
}  // namespace coppice::bake

// Memory that runs out before the first command may end the program.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char** argv) {
  const std::string name = std::string("coppice ") + coppice::bake::kEvaluateCommand;
  return coppice::bake::run_program({name.c_str(), coppice::bake::kEvaluateAbout, coppice::bake::declare_evaluate}, argc, argv);
}
