#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "atomic_file.h"
#include "bake_arguments.h"
#include "bake_batch.h"
#include "batch_manifest.h"
#include "batch_report.h"
#include "cluster_batch.h"
#include "commands.h"
#include "output.h"
#include "plant_cost.h"
#include "plant_pictures.h"
#include "plant_record.h"
#include "printable.h"
#include "progress_bar.h"
#include "slurm.h"
#include "stopwatch.h"
#include "temporary_file.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

struct BakeAllCommand {
  std::filesystem::path input, output, report, html, journal;
  BakeRequest bake;
  LimitArguments limits;
  std::string cache, cache_mode = "read-write";
  bool no_cache = false, explain = false;
  bool slurm = false, print = false;
  std::filesystem::path coppice;
  std::vector<std::string> sbatch_options;
  std::uint32_t job_count = 0, thread_count = 0;
  std::uint32_t shard = 1, shard_count = 1;
  bool pictures = false;  ///< for somebody else's page
  bool quiet = false;
};

Result<std::vector<BatchPlant>> plants_of(const BakeAllCommand& arguments) {
  std::error_code error;
  const bool is_folder = std::filesystem::is_directory(arguments.input, error);
  if (!is_folder && !is_plant_file(arguments.input)) return plants_of_manifest(arguments.input, arguments.output, arguments.bake);
  COPPICE_TRY(options, bake_options(arguments.bake));
  std::vector<BatchPlant> plants{{arguments.input, arguments.output / (arguments.input.stem() += ".coppice"), options}};
  if (is_folder) {
    COPPICE_CHECK(move_into(plants, plants_of_folder(arguments.input, arguments.output, options)));
  }
  for (BatchPlant& plant : plants) plant.all_variants = arguments.bake.all_variants;
  return plants;
}

Result<void> check_reports(const BakeAllCommand& arguments, const std::vector<BatchPlant>& plants) {
  std::vector<std::filesystem::path> files{arguments.input};
  for (const BatchPlant& plant : plants) {
    files.insert(files.end(), {plant.input, plant.output});
    files.insert(files.end(), plant.files.begin(), plant.files.end());
  }
  return check_outputs({{arguments.report, Content::text}, {arguments.html, Content::text}, {arguments.journal, Content::text}}, files);
}

Result<std::vector<BatchPlant>> checked_plants(const BakeAllCommand& arguments) {
  COPPICE_CHECK(refuse_standard_output(arguments.output, "the output is a folder"));
  COPPICE_TRY(files, plants_of(arguments));
  std::vector<BatchPlant> plants = expand_variants(files, job_limits(arguments.limits));
  estimate_inputs(plants);
  COPPICE_CHECK(check_batch(plants, {arguments.input}));
  COPPICE_CHECK(make_folder(arguments.output));
  COPPICE_CHECK(check_reports(arguments, plants));
  return plants;
}

/// Those of the shard that was asked for.
std::vector<BatchPlant> shard_of(const BakeAllCommand& arguments, std::vector<BatchPlant> plants) {
  if (arguments.shard_count == 1) return plants;
  const std::vector<std::vector<std::uint32_t>> shards = plan_shards(costs_of(plants), arguments.shard_count);
  std::vector<BatchPlant> shard;
  for (const std::uint32_t plant : shards[arguments.shard - 1]) shard.push_back(plants[plant]);
  return shard;
}

/// Others bake parts of the same batch.
bool is_a_part(const BakeAllCommand& arguments) {
  return arguments.shard_count > 1 || !arguments.journal.empty();
}

/// The plants' threads, where the user says how many there are in all; else bake_batch deals out the machine's.
void share_threads(const BakeAllCommand& arguments, Batch& batch) {
  if (arguments.thread_count == 0) return;
  if (arguments.job_count == 0) batch.job_count = std::min(batch.job_count, arguments.thread_count);
  for (BatchPlant& plant : batch.plants)
    plant.options.thread_count = std::max(1u, (arguments.thread_count + batch.job_count - 1) / std::max(1u, batch.job_count));
}

/// Fills in the caches of the batch. errors  as parse_cache_location and credentials_of_environment
Result<void> set_caches(const BakeAllCommand& arguments, BatchOptions& options) {
  options.explain = arguments.explain;
  if (arguments.no_cache) return {};
  options.cache = arguments.output / kOwnCache;
  if (arguments.cache.empty()) return {};
  COPPICE_TRY(location, parse_cache_location(arguments.cache));
  COPPICE_TRY(credentials, credentials_of_environment());
  options.shared = {std::move(location), arguments.cache_mode == "read" ? CacheMode::read : CacheMode::read_write, std::move(credentials)};
  return {};
}

Result<Batch> run_batch(const BakeAllCommand& arguments) {
  COPPICE_TRY(plants, checked_plants(arguments));
  Batch batch;
  batch.output_folder = arguments.output;
  batch.plants = shard_of(arguments, std::move(plants));
  batch.job_count = arguments.job_count > 0 ? arguments.job_count : default_job_count(batch.plants);
  share_threads(arguments, batch);
  ProgressBar bar(arguments.quiet ? ProgressBar::Visibility::never : ProgressBar::Visibility::on_terminal);
  Stopwatch watch;
  BatchOptions options{{}, batch.job_count, job_limits(arguments.limits)};
  COPPICE_CHECK(set_caches(arguments, options));
  options.cache_reported = [&batch](const CacheReport& report) { batch.cache = report; };
  options.other_batches = is_a_part(arguments);
  if (arguments.pictures || !arguments.html.empty()) options.pictures = picture_folder(arguments.output);
  std::optional<Journal> journal;
  Result<void> journaled;
  if (!arguments.journal.empty()) {
    COPPICE_TRY(opened, Journal::open(arguments.journal));
    journal.emplace(std::move(opened));
    options.ended = [&](const BatchPlant& plant, const BatchResult& result) {
      if (auto added = journal->add(plant, result); !added && journaled) journaled = std::move(added);
    };
  }
  COPPICE_TRY(results, bake_batch(batch.plants, options, [&bar](const BatchStatus& status) { show_batch(bar, status); }));
  if (!journaled) return journaled.error();
  batch.results = std::move(results);
  batch.seconds = watch.lap();
  return batch;
}

/// The page, with the pictures that no task has drawn.
std::string page_of(const BakeAllCommand& arguments, const Batch& batch) {
  if (arguments.html.empty()) return {};
  const std::vector<std::string> failures =
      draw_missing_pictures(batch.plants, batch.results, picture_folder(batch.output_folder), default_job_count(batch.plants));
  for (std::size_t i = 0; i < batch.plants.size(); ++i)
    if (!failures[i].empty()) print_warnings(batch.plants[i].input, {"no picture of it: " + failures[i]});
  return batch_html(batch);
}

int report_batch(const BakeAllCommand& arguments, const Batch& batch) {
  for (std::size_t i = 0; i < batch.plants.size(); ++i) print_warnings(batch.plants[i].input, batch.results[i].warnings);
  const std::string json = batch_json(batch), page = page_of(arguments, batch);
  if (const int failed = write_outputs({{arguments.report, bytes_of(json)}, {arguments.html, bytes_of(page)}}, ""); failed != 0)
    return failed;
  const bool prints = !is_standard_output(arguments.report) && !is_standard_output(arguments.html);
  if (!arguments.quiet && prints) print_batch(batch);
  if (prints) print_reasons(batch);
  print_cache_trouble(batch.cache);
  print_failures(batch, arguments.input);
  return count_of(batch, BatchOutcome::failed) > 0 ? 1 : 0;
}

int run(const BakeAllCommand& arguments) {
  const auto batch = run_batch(arguments);
  return batch ? report_batch(arguments, *batch) : report_failure(arguments.input, batch.error());
}

/// A folder as nodes name it.
std::filesystem::path absolute_folder(const std::filesystem::path& folder) {
  std::filesystem::path path = std::filesystem::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

/// Options of the command that every task gets; those of a bake are in its list.
std::vector<std::string> task_options(const BakeAllCommand& arguments) {
  std::vector<std::string> words;
  const auto add = [&words](const char* name, const std::string& value) { words.insert(words.end(), {name, value}); };
  if (arguments.job_count > 0) add("--jobs", std::to_string(arguments.job_count));
  if (!arguments.html.empty()) words.emplace_back("--pictures");
  if (arguments.limits.max_memory_mb > 0) add("--max-memory-mb", std::to_string(arguments.limits.max_memory_mb));
  if (arguments.limits.max_seconds > 0.0) add("--max-seconds", formatted("%.9g", arguments.limits.max_seconds));
  if (arguments.explain) words.emplace_back("--explain");
  if (arguments.no_cache) words.emplace_back("--no-cache");
  if (!arguments.no_cache && !arguments.cache.empty())
    words.insert(words.end(), {"--cache-mode", arguments.cache_mode, "--cache", arguments.cache});
  return words;
}

/// A script's comments and JSON hold no newline and nothing but UTF-8.
Result<void> check_words(const ClusterBatch& batch) {
  std::vector<std::string> words{batch.output_folder.string(), batch.coppice.string()};
  words.insert(words.end(), batch.task_options.begin(), batch.task_options.end());
  words.insert(words.end(), batch.sbatch_options.begin(), batch.sbatch_options.end());
  for (const std::string& word : words)
    if (!is_printable(word)) return Error{Status::invalid_argument, "tasks' scripts cannot hold this", Error::kNoOffset, printable(word)};
  return {};
}

Result<ClusterBatch> cluster_batch_of(const BakeAllCommand& arguments) {
  ClusterBatch batch;
  batch.output_folder = arguments.output;
  COPPICE_CHECK(move_into(batch.plants, checked_plants(arguments)));
  COPPICE_CHECK(set_caches(arguments, batch.options));
  batch.options.look_up_only = batch.options.other_batches = true;
  batch.options.explain = false;
  batch.task_options = task_options(arguments);
  batch.sbatch_options = arguments.sbatch_options;
  batch.coppice = arguments.coppice;
  std::error_code error;
  if (batch.coppice.empty()) batch.coppice = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return system_error("cannot tell where this program is", "/proc/self/exe", error.value());
  for (const BatchPlant& plant : batch.plants) {
    COPPICE_TRY(entry, manifest_entry(plant, batch.output_folder));
    batch.entries.push_back(std::move(entry));
  }
  COPPICE_CHECK(check_words(batch));
  return batch;
}

volatile std::sig_atomic_t interrupted = 0;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): a signal handler's

/// While it lives, Ctrl-C is a wish to leave.
class LeaveOnInterrupt {
 public:
  LeaveOnInterrupt() {
    interrupted = 0;
    struct sigaction action {};
    action.sa_handler = [](int) { interrupted = 1; };
    ::sigaction(SIGINT, &action, &before_);
  }
  LeaveOnInterrupt(const LeaveOnInterrupt&) = delete;
  LeaveOnInterrupt& operator=(const LeaveOnInterrupt&) = delete;
  ~LeaveOnInterrupt() { ::sigaction(SIGINT, &before_, nullptr); }

 private:
  struct sigaction before_ {};
};

/// Bakes with a progress bar and lines about what was submitted and lost. Ctrl-C leaves, and the tasks go on.
Result<std::optional<std::vector<BatchResult>>> follow_on_cluster(ClusterBatch& batch, bool quiet) {
  ProgressBar bar(quiet ? ProgressBar::Visibility::never : ProgressBar::Visibility::on_terminal);
  batch.progress = [&bar](const BatchStatus& status) { show_batch(bar, status); };
  batch.warn = [&bar](const std::string& line) {
    bar.clear();
    std::fprintf(stderr, "coppice: %s\n", printable(line).c_str());
  };
  batch.say = [&batch, quiet](const std::string& line) {
    if (!quiet) batch.warn(line);
  };
  batch.is_stopped = [] { return interrupted != 0; };
  const LeaveOnInterrupt leave;
  auto results = bake_on_cluster(batch);
  bar.clear();
  return results;
}

/// Ctrl-C does not end what the cluster does.
int leave() {
  std::fputs("coppice: the tasks go on. The same command takes the batch up again; scancel with the job's number ends them.\n", stderr);
  return 130;  // a shell's exit code for a command that Ctrl-C ended
}

int run_on_cluster(BakeAllCommand arguments) {
  if (const auto possible = refuse_standard_output(arguments.output, "the output is a folder"); !possible)
    return report_failure(arguments.output, possible.error());
  arguments.output = absolute_folder(arguments.output);
  arguments.input = absolute_folder(arguments.input);
  if (const auto cache = parse_cache_location(arguments.cache); cache && !cache->folder.empty())
    arguments.cache = absolute_folder(cache->folder).string();
  Stopwatch watch;
  auto cluster = cluster_batch_of(arguments);
  if (!cluster) return report_failure(arguments.input, cluster.error());
  if (arguments.print) {
    const auto script = write_tasks(*cluster);
    if (!script) return report_failure(arguments.input, script.error());
    std::fputs(script->c_str(), stdout);
    return 0;
  }
  Batch batch;
  cluster->options.cache_reported = [&batch](const CacheReport& report) { batch.cache = report; };
  auto results = follow_on_cluster(*cluster, arguments.quiet);
  if (!results) return report_failure(arguments.input, results.error());
  if (!*results) return leave();
  batch.output_folder = arguments.output;
  batch.plants = std::move(cluster->plants);
  batch.results = **std::move(results);
  batch.seconds = watch.lap();
  return report_batch(arguments, batch);
}

/// "3/16" to shard 3 of 16.
void add_shard_option(CLI::App& command, BakeAllCommand& arguments) {
  command
      .add_option_function<std::string>(
          "--shard",
          [&arguments](const std::string& text) {
            const std::size_t slash = text.find('/');
            arguments.shard = number_of<std::uint32_t>(text.substr(0, slash)).value_or(0);
            arguments.shard_count = slash == std::string::npos ? 0 : number_of<std::uint32_t>(text.substr(slash + 1)).value_or(0);
            if (arguments.shard < 1 || arguments.shard > arguments.shard_count || arguments.shard_count > 100'000)
              throw CLI::ValidationError("--shard", "not a part of so many, from 1/N to N/N: " + text);
          },
          "Bake the I-th of N parts of all plants, which take about equally long; the parts are the same on every machine. Each writes to "
          "a report of its own; they may bake into one OUT at the same time")
      ->type_name("I/N");
}

void add_cache_options(CLI::App& command, BakeAllCommand& arguments) {
  command
      .add_option("--cache", arguments.cache,
                  "A cache that people and machines share: a folder, in place of OUT/.coppice-cache, or an address like https://host/path, "
                  "behind it; without it that of COPPICE_CACHE. Credentials are in COPPICE_CACHE_CREDENTIALS (USER:PASSWORD or Bearer "
                  "TOKEN) or ~/.netrc. A cache that is of no use costs seconds, and no plant")
      ->type_name("FOLDER|URL")
      ->envname(kCacheVariable);
  command.add_option("--cache-mode", arguments.cache_mode, "Whether results are sent to the shared cache, or it is only read")
      ->check(CLI::IsMember({"read", "read-write"}))
      ->type_name("read|read-write")
      ->capture_default_str();
  command.add_flag("--no-cache", arguments.no_cache, "Bake everything and keep nothing but the outputs");
  command.add_flag("--explain", arguments.explain,
                   "Say why each plant was baked: what its key differs in from the nearest entry in the cache");
}

void add_cluster_options(CLI::App& command, BakeAllCommand& arguments) {
  command.add_flag("--slurm", arguments.slurm,
                   "Bake on the nodes of a Slurm cluster. OUT and the inputs must be in folders that all nodes share. What follows -- are "
                   "options of sbatch. The same command again takes up where this one was stopped");
  command.add_flag("--print", arguments.print,
                   "With --slurm: print the script of the tasks instead of submitting it, for other schedulers");
  command
      .add_option("--coppice", arguments.coppice, "With --slurm: where the nodes have this program; by default where this machine has it")
      ->type_name("PATH");
  command.add_option("sbatch", arguments.sbatch_options, "With --slurm, after --: options of sbatch, as in -- -p long --mem 8G")
      ->type_name("-- OPTION ...");
}

void check_arguments(const BakeAllCommand& arguments) {
  if (arguments.cache_mode == "read" && arguments.cache.empty())
    throw CLI::ValidationError("--cache-mode", std::string("there is no shared cache: name one with --cache or ") + kCacheVariable);
  if (const std::string word = refused_sbatch_option(arguments.sbatch_options); !word.empty())
    throw CLI::ValidationError(word, "not with bake-all, which submits, finds and waits for the tasks itself");
  const auto needs_slurm = [&](bool given, const std::string& name, const char* why) {
    if (given && !arguments.slurm) throw CLI::ValidationError(name, why);
  };
  needs_slurm(arguments.print, "--print", "needs --slurm");
  needs_slurm(!arguments.coppice.empty(), "--coppice", "needs --slurm");
  if (!arguments.sbatch_options.empty())
    needs_slurm(true, arguments.sbatch_options.front(), "one input too many; options of sbatch need --slurm");
  if (arguments.slurm && is_a_part(arguments))
    throw CLI::ValidationError("--slurm", "deals out all plants by itself: not with --shard or --journal");
  if (arguments.slurm && arguments.thread_count > 0)
    throw CLI::ValidationError("--threads", "a task has the processors that Slurm gives it: -- --cpus-per-task N");
  // The entries of a list may have what the command lacks.
  std::error_code error;
  if (std::filesystem::is_directory(arguments.input, error) || is_plant_file(arguments.input)) check_bake_request(arguments.bake);
}

}  // namespace

std::string sbatch_hint(const std::vector<std::string>& words) {
  const auto has = [&words](const char* word) { return std::ranges::find(words, word) != words.end(); };
  return has("--slurm") && !has("--") ? "Options of sbatch follow --, as in --slurm -- -p long\n" : "";
}

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
  add_count_option(*command, "--jobs", arguments->job_count,
                   "Plants at a time; 0 for as many as there are processors and as fit into half of the free memory. The result is the "
                   "same for any number");
  add_count_option(*command, "--threads", arguments->thread_count,
                   "Processors to use, for all plants together; 0 for all. The result is the same for any number");
  add_shard_option(*command, *arguments);
  add_bake_options(*command, arguments->bake);
  add_limit_options(*command, arguments->limits);
  add_cache_options(*command, *arguments);
  add_output_option(*command, "--report", arguments->report, "Write what became of each plant to this JSON file")->type_name("F.json");
  add_output_option(*command, "--html", arguments->html,
                    "Write a page that opens in any browser, without a network: what became of each plant, with a picture of it near and "
                    "far. Pictures are kept in OUT/.coppice-pictures, which may be deleted at any time")
      ->type_name("F.html");
  command->add_flag("--pictures", arguments->pictures,
                    "Draw these pictures although there is no page: for the --html of a batch that this is a part of");
  add_output_option(*command, "--journal", arguments->journal,
                    "Add a line to this file for each plant as soon as it has ended: its entry of --report. Other coppices with a journal "
                    "may bake into OUT at the same time")
      ->type_name("F.jsonl");
  add_cluster_options(*command, *arguments);
  command->add_flag("--quiet", arguments->quiet, "Print nothing but warnings and errors");
  command->callback([arguments, exit_code] {
    check_arguments(*arguments);
    *exit_code = arguments->slurm ? run_on_cluster(*arguments) : run(*arguments);
  });
}

}  // namespace coppice::bake
