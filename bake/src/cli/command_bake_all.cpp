#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "bake_arguments.h"
#include "bake_batch.h"
#include "batch_manifest.h"
#include "cache_arguments.h"
#include "commands.h"
#include "limit_arguments.h"
#include "output.h"
#include "printable.h"
#include "progress_bar.h"
#include "temporary_file.h"

namespace coppice::bake {
namespace {

struct BakeAllCommand {
  std::filesystem::path input, output, report;
  BakeArguments bake;
  LimitArguments limits;
  CacheArguments cache;
  std::uint32_t job_count = 0;
  bool quiet = false;
};

/// Everything about a batch that has ended.
struct Batch {
  std::filesystem::path output_folder;
  std::vector<BatchPlant> plants;
  std::vector<BatchResult> results;
  std::uint32_t job_count = 0;
  double seconds = 0.0;
  CacheReport cache;
};

std::size_t count_of(const Batch& batch, BatchOutcome outcome) {
  return static_cast<std::size_t>(std::ranges::count(batch.results, outcome, &BatchResult::outcome));
}

double bytes_per_leaf(const BatchResult& result) {
  return result.source_leaves > 0 ? static_cast<double>(result.foliage_bytes) / result.source_leaves : 0.0;
}

nlohmann::ordered_json plant_json(const BatchPlant& plant, const BatchResult& result) {
  nlohmann::ordered_json json = {
      {"input", plant.input.string()}, {"output", plant.output.string()}, {"outcome", outcome_name(result.outcome)}};
  if (result.outcome == BatchOutcome::failed)
    json["error"] = result.error;
  else
    json.update({{"source_leaves", result.source_leaves},
                 {"file_bytes", result.file_bytes},
                 {"foliage_bytes", result.foliage_bytes},
                 {"bytes_per_leaf", bytes_per_leaf(result)}});
  json.update({{"key", result.key},
               {"seconds", result.seconds},
               {"peak_rss_bytes", result.peak_rss_bytes},
               {"warnings", result.warnings},
               {"because", result.because}});
  return json;
}

std::string batch_json(const Batch& batch) {
  nlohmann::ordered_json plants = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < batch.plants.size(); ++i) plants.push_back(plant_json(batch.plants[i], batch.results[i]));
  const nlohmann::ordered_json root = {{"baked", count_of(batch, BatchOutcome::baked)},
                                       {"cached", count_of(batch, BatchOutcome::cached)},
                                       {"failed", count_of(batch, BatchOutcome::failed)},
                                       {"seconds", batch.seconds},
                                       {"jobs", batch.job_count},
                                       {"cache", cache_json(batch.cache)},
                                       {"plants", std::move(plants)}};
  return root.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

/// "oaks/large" of OUT/oaks/large.coppice
std::string plant_label(const Batch& batch, std::size_t plant) {
  std::filesystem::path name = batch.plants[plant].output.lexically_relative(batch.output_folder);
  return shown(name.replace_extension());
}

void print_table(const Batch& batch) {
  std::size_t width = 5;
  for (std::size_t i = 0; i < batch.plants.size(); ++i) width = std::max(width, plant_label(batch, i).size());
  const int columns = static_cast<int>(width);
  std::printf("%-*s %9s %10s %7s %8s\n", columns, "plant", "leaves", "bytes", "B/leaf", "seconds");
  for (std::size_t i = 0; i < batch.plants.size(); ++i) {
    const BatchResult& result = batch.results[i];
    const std::string label = plant_label(batch, i);
    if (result.outcome == BatchOutcome::failed)
      std::printf("%-*s %9s %10s %7s %8.1f  failed\n", columns, label.c_str(), "-", "-", "-", result.seconds);  // stderr says why
    else
      std::printf("%-*s %9u %10llu %7.1f %8.1f  %s\n", columns, label.c_str(), result.source_leaves,
                  static_cast<unsigned long long>(result.file_bytes), bytes_per_leaf(result), result.seconds, outcome_name(result.outcome));
  }
  std::printf("%zu plants in %.1f s, %u at a time: %zu baked, %zu cached, %zu failed\n", batch.plants.size(), batch.seconds,
              batch.job_count, count_of(batch, BatchOutcome::baked), count_of(batch, BatchOutcome::cached),
              count_of(batch, BatchOutcome::failed));
}

void print_reasons(const Batch& batch) {
  for (std::size_t i = 0; i < batch.plants.size(); ++i) std::fputs(because_text(plant_label(batch, i), batch.results[i]).c_str(), stdout);
}

/// Broken between words, or within those that are longer than a line. Lines after the first are indented. text: may be printed
std::string wrapped(const std::string& text, std::size_t columns) {
  const std::string indent = "\n    ";
  std::string lines, word;
  std::size_t column = 0, word_columns = 0;
  const auto end_word = [&] {
    if (column > 0 && column + 1 + word_columns > columns)
      lines += indent, column = indent.size() - 1;
    else if (column > 0)
      lines += ' ', ++column;
    lines += std::exchange(word, "");
    column += std::exchange(word_columns, 0);
  };
  for (const char c : text) {
    const bool is_character = (static_cast<unsigned char>(c) & 0xc0u) != 0x80u;
    if (c == ' ' || (is_character && word_columns + indent.size() > columns)) end_word();
    if (c == ' ') continue;
    word += c;
    if (is_character) ++word_columns;
  }
  end_word();
  return lines;
}

/// Why a plant was not baked. The plant's path, which most errors name too, is there once, as seen from the batch's folder.
void print_failure(const BakeAllCommand& arguments, const BatchPlant& plant, const BatchResult& result) {
  constexpr std::size_t kColumns = 100;
  std::string error = result.error;
  const std::string path = plant.input.string();
  for (const std::string& place : {": " + path, path + ": ", path})
    if (const std::size_t at = error.find(place); at != std::string::npos) error.erase(at, place.size());
  std::error_code unreadable;
  const bool is_folder = std::filesystem::is_directory(arguments.input, unreadable);
  const std::filesystem::path name = plant.input.lexically_relative(is_folder ? arguments.input : arguments.input.parent_path());
  const std::string shown_name = name.empty() || *name.begin() == ".." ? shown(plant.input) : shown(name);
  std::fprintf(stderr, "%s\n", wrapped("coppice: " + shown_name + ": not baked: " + printable(error), kColumns).c_str());
}

Result<std::vector<BatchPlant>> plants_of(const BakeAllCommand& arguments) {
  std::error_code error;
  if (std::filesystem::is_directory(arguments.input, error)) {
    COPPICE_TRY(options, bake_options(arguments.bake));
    COPPICE_TRY(plants, plants_of_folder(arguments.input, arguments.output, options));
    for (BatchPlant& plant : plants) plant.all_variants = arguments.bake.import.all_variants;
    return plants;
  }
  if (is_plant_file(arguments.input)) {
    COPPICE_TRY(options, bake_options(arguments.bake));
    const std::filesystem::path name = arguments.input.stem() += ".coppice";
    BatchPlant plant{arguments.input, arguments.output / name, std::move(options)};
    plant.all_variants = arguments.bake.import.all_variants;
    return std::vector{std::move(plant)};
  }
  return plants_of_manifest(arguments.input, arguments.output, arguments.bake);
}

Result<void> check_report(const BakeAllCommand& arguments, const std::vector<BatchPlant>& plants) {
  if (arguments.report.empty()) return {};
  std::vector<std::filesystem::path> others{arguments.input};
  for (const BatchPlant& plant : plants) {
    others.push_back(plant.input);
    others.push_back(plant.output);
  }
  return check_output(arguments.report, others, Content::text);
}

Result<Batch> run_batch(const BakeAllCommand& arguments) {
  COPPICE_CHECK(refuse_standard_output(arguments.output, "the output is a folder"));
  COPPICE_TRY(files, plants_of(arguments));
  const std::vector<BatchPlant> plants = expand_variants(files, job_limits(arguments.limits));
  COPPICE_CHECK(check_batch(plants));
  std::error_code error;
  std::filesystem::create_directories(arguments.output, error);
  if (error) return system_error("cannot make the folder", arguments.output, error.value());
  COPPICE_CHECK(check_report(arguments, plants));

  Batch batch{arguments.output, plants, {}, 0, 0.0, {}};
  batch.job_count = arguments.job_count > 0 ? arguments.job_count : default_job_count(batch.plants);
  ProgressBar bar(arguments.quiet ? ProgressBar::Visibility::never : ProgressBar::Visibility::on_terminal);
  const auto start = std::chrono::steady_clock::now();
  BatchOptions options{{}, batch.job_count, job_limits(arguments.limits)};
  COPPICE_CHECK(set_caches(arguments.cache, arguments.output, options));
  options.cache_reported = [&batch](const CacheReport& report) { batch.cache = report; };
  COPPICE_TRY(results, bake_batch(batch.plants, options, [&bar](const BatchStatus& status) {
                bar.show("bake-all", status.fraction,
                         std::to_string(status.ended) + " of " + std::to_string(status.count) + "; " + status.running);
              }));
  batch.results = std::move(results);
  batch.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return batch;
}

int run(const BakeAllCommand& arguments) {
  const auto batch = run_batch(arguments);
  if (!batch) return report_failure(arguments.input, batch.error());
  for (std::size_t i = 0; i < batch->plants.size(); ++i) print_warnings(batch->plants[i].input, batch->results[i].warnings);
  const std::string json = batch_json(*batch);
  if (const int failed = write_outputs({{arguments.report, bytes_of(json)}}, ""); failed != 0) return failed;
  if (!arguments.quiet && !is_standard_output(arguments.report)) print_table(*batch);
  if (!is_standard_output(arguments.report)) print_reasons(*batch);
  print_cache_trouble(batch->cache);
  for (std::size_t i = 0; i < batch->plants.size(); ++i)
    if (batch->results[i].outcome == BatchOutcome::failed) print_failure(arguments, batch->plants[i], batch->results[i]);
  return count_of(*batch, BatchOutcome::failed) > 0 ? 1 : 0;
}

}  // namespace

void add_bake_all_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<BakeAllCommand>();
  CLI::App* command = app.add_subcommand("bake-all", "Bake every plant of a folder or a list, those that have changed since the last time");
  command->footer(
      "A folder is searched with all folders in it for .glb and .gltf files; OUT gets the same folders. A list is a JSON file like\n"
      "  [{\"input\": \"oak.glb\"},\n"
      "   {\"input\": \"oak.glb\", \"output\": \"far/oak.coppice\", \"metric\": \"mi\", \"leaf_material\": \"^Leaves$\"}]\n"
      "with paths beside it, and the options above, as keys with _ for -, for single plants; those of the command are for all others.\n"
      "Results are kept in OUT/.coppice-cache, by input (with all files that it refers to), options and version of the baker: what is "
      "there is not baked again. A run that was killed goes on when it is started again. The cache grows; coppice cache prune makes it "
      "smaller, and it may be deleted at any time. --cache shares it between machines.\n"
      "Exit code 1 if any plant failed; the others are baked all the same.\n"
      "  coppice bake-all plants -o baked --report baked.json");
  command->add_option("input", arguments->input, "A folder of plants, a list of them, or one")
      ->required()
      ->type_name("FOLDER|LIST.json|IN.glb|IN.gltf");
  add_output_option(*command, "-o,--output", arguments->output, "Folder for the .coppice files; made if it is missing")
      ->required()
      ->type_name("OUT/");
  command
      ->add_option(
          "--jobs", arguments->job_count,
          "Plants at a time; 0 for as many as there are processors and as fit into half of the free memory. The result is the same "
          "for any number")
      ->check(CLI::Range(0u, 1024u))
      ->type_name("N")
      ->capture_default_str();
  add_bake_options(*command, arguments->bake);
  add_limit_options(*command, arguments->limits);
  add_cache_options(*command, arguments->cache);
  add_output_option(*command, "--report", arguments->report, "Write what became of each plant to this JSON file")->type_name("F.json");
  command->add_flag("--quiet", arguments->quiet, "Print nothing but warnings and errors");
  command->callback([arguments, exit_code] {
    // The entries of a list may have what the command lacks.
    std::error_code error;
    if (std::filesystem::is_directory(arguments->input, error) || is_plant_file(arguments->input)) check_bake_arguments(arguments->bake);
    *exit_code = run(*arguments);
  });
}

}  // namespace coppice::bake
