#include "farm_command.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "batch_manifest.h"
#include "farm_follow.h"
#include "farm_run.h"
#include "farm_tries.h"
#include "load_batch.h"
#include "output.h"
#include "plant_record.h"
#include "printable.h"
#include "progress_bar.h"
#include "sbatch_options.h"
#include "slurm.h"
#include "temporary_file.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

/// Where this program is, for nodes that see it there too.
Result<fs::path> own_path() {
  std::error_code error;
  fs::path path = fs::read_symlink("/proc/self/exe", error);
  if (error) return system_error("cannot tell where this program is", "/proc/self/exe", error.value());
  return path;
}

/// Files of rules that tasks read, one for each text.
class ClassFiles {
 public:
  explicit ClassFiles(fs::path folder) : folder_(std::move(folder)) {}
  Result<fs::path> file_of(const std::vector<ClassRule>& rules) {
    if (rules.empty()) return fs::path();
    const std::string text = classes_text(rules);
    const auto [found, is_new] = files_.try_emplace(text, folder_ / ("classes-" + std::to_string(files_.size()) + ".json"));
    if (is_new) {
      COPPICE_CHECK(write_file_atomically(found->second, bytes_of(text)));
    }
    return found->second;
  }

 private:
  fs::path folder_;
  std::map<std::string, fs::path> files_;
};

/// A script's comments and JSON hold no newline and nothing but UTF-8.
Result<void> check_words(const FarmBatch& batch, const FarmArguments& arguments) {
  std::vector<std::string> words{batch.output_folder.string(), arguments.coppice.string()};
  words.insert(words.end(), batch.task_options.begin(), batch.task_options.end());
  words.insert(words.end(), batch.server_options.begin(), batch.server_options.end());
  words.insert(words.end(), arguments.sbatch_options.begin(), arguments.sbatch_options.end());
  for (const std::string& word : words)
    if (!is_printable(word)) return Error{Status::invalid_argument, "tasks' scripts cannot hold this", Error::kNoOffset, printable(word)};
  return {};
}

Result<FarmRun> run_of(const FarmBatch& batch, const FarmArguments& arguments, const fs::path& folder) {
  FarmRun run;
  run.folder = folder;
  run.output_folder = batch.output_folder;
  run.coppice = arguments.coppice;
  if (run.coppice.empty()) {
    COPPICE_CHECK(move_into(run.coppice, own_path()));
  }
  run.submitter = arguments.print ? Submitter::hand : Submitter::slurm;
  run.sbatch_options = arguments.sbatch_options;
  run.task_options = batch.task_options;
  run.server_options = batch.server_options;
  ClassFiles classes(folder);
  for (const BatchPlant& plant : batch.plants) {
    COPPICE_TRY(classes_file, classes.file_of(plant.options.import.classes));
    COPPICE_TRY(entry, manifest_entry(plant, batch.output_folder, classes_file));
    run.plants.push_back({fs::absolute(plant.input).lexically_normal(), plant.output, std::move(entry), plant.cost, plant.failure, false});
  }
  return run;
}

/// Takes from the caches what is there, so that a batch that has hardly changed needs hardly a task.
Result<void> load_plants(const FarmBatch& batch, FarmRun& run) {
  if (batch.caches.cache.empty()) return {};
  BatchOptions options = batch.caches;
  options.cache_reported = [&run](const CacheReport& report) { run.cache = report; };
  COPPICE_TRY(results, load_batch(batch.plants, options));
  std::string journal;
  for (std::size_t plant = 0; plant < results.size(); ++plant) {
    if (results[plant].outcome != BatchOutcome::cached) continue;
    journal += journal_line(batch.plants[plant], results[plant]);
    run.plants[plant].is_cached = true;
  }
  if (run.cache.gave_up) {
    COPPICE_CHECK(write_file_atomically(cache_given_up_path(run.folder), {}));
  }
  return write_file_atomically(submitter_journal(run.folder), bytes_of(journal));
}

/// Plants that are given to tasks, in arrays.
Result<void> write_plan(const FarmRun& run) {
  std::vector<std::uint32_t> given;
  std::vector<PlantCost> costs;
  for (std::uint32_t plant = 0; plant < run.plants.size(); ++plant)
    if (run.plants[plant].failure.empty() && !run.plants[plant].is_cached) {
      given.push_back(plant);
      costs.push_back(run.plants[plant].cost);
    }
  PlanOptions options;
  if (run.submitter == Submitter::hand) options.arrays = FarmArrays::one;
  const std::uint32_t processors = run.submitter == Submitter::slurm ? slurm_processor_count() : 0;
  if (processors > 0) options.slots = std::max(1u, processors / processors_of_task(run.sbatch_options));
  std::uint32_t number = 0;
  for (FarmArray& array : plan_arrays(costs, options)) {
    for (FarmTask& task : array.tasks)
      for (std::uint32_t& plant : task.plants) plant = given[plant];
    Submission submission;
    submission.number = ++number;
    submission.memory_bytes = array.memory_bytes;
    submission.minutes = array.minutes;
    submission.tasks = std::move(array.tasks);
    if (run.submitter == Submitter::hand) submission.submitted_s = static_cast<double>(std::time(nullptr));
    COPPICE_CHECK(write_submission(run, submission));
  }
  return {};
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

std::string status_text(const FarmStatus& status) {
  std::string text = std::to_string(status.ended) + " of " + std::to_string(status.count) + "; ";
  if (!status.note.empty()) return text + status.note;
  text +=
      std::to_string(status.running) + (status.running == 1 ? " task runs, " : " tasks run, ") + std::to_string(status.waiting) + " wait";
  return status.running > 0 || status.waits_for.empty() ? text : text + ": " + status.waits_for;
}

/// The submitter's and the tasks'; what the submitter did not find they have asked for again.
CacheReport caches_of(const FarmRun& run) {
  const CacheReport tasks = read_task_caches(run.folder, run.cache.where);
  CacheReport caches = run.cache;
  if (tasks.where.empty()) return caches;
  caches.lacking = caches.unasked = caches.unsent = 0;
  add_cache_report(caches, tasks);
  return caches;
}

Batch batch_of(const FarmRun& run, FarmResults results) {
  Batch batch;
  batch.output_folder = run.output_folder;
  for (const FarmPlant& plant : run.plants) batch.plants.push_back({plant.input, plant.output, {}});
  for (FarmPlantEnd& plant : results.plants) {
    batch.results.push_back(std::move(plant.result));
    batch.places.push_back({std::move(plant.node), plant.queue_seconds, plant.attempts, std::move(plant.log_tail)});
  }
  batch.job_count = static_cast<std::uint32_t>(results.most_running);
  batch.seconds = results.seconds;
  batch.task_count = results.task_count;
  batch.retried_task_count = results.retried_task_count;
  batch.tries = std::move(results.tries);
  batch.cache = caches_of(run);
  return batch;
}

std::vector<std::string> jobs_of(const std::vector<Submission>& submissions) {
  std::vector<std::string> jobs;
  for (const Submission& submission : submissions)
    if (!submission.job.empty()) jobs.push_back(submission.job);
  return jobs;
}

/// Seconds since a run's folder was made.
double since_made(const FarmRun& run) {
  std::error_code error;
  const auto made = fs::last_write_time(run.folder / "tries", error);
  return error ? 0.0 : std::chrono::duration<double>(fs::file_time_type::clock::now() - made).count();
}

/// Of a run that had ended before it was followed, what its report says of time.
void take_reported(const fs::path& report, Batch& batch) {
  const auto bytes = read_file(report);
  if (!bytes) return;
  const auto json = nlohmann::json::parse(bytes->begin(), bytes->end(), nullptr, false);
  if (!json.is_object() || !json.value("seconds", nlohmann::json()).is_number() ||
      !json.value("jobs", nlohmann::json()).is_number_unsigned())
    return;
  batch.seconds = json["seconds"].get<double>();
  batch.job_count = json["jobs"].get<std::uint32_t>();
}

}  // namespace

void add_farm_options(CLI::App& command, FarmArguments& arguments) {
  command.add_flag("--slurm", arguments.slurm,
                   "Bake on the nodes of a Slurm cluster. OUT and the inputs must be in folders that all nodes share. What follows -- are "
                   "options of sbatch");
  command.add_flag("--attach", arguments.attach,
                   "Take up the newest run on a cluster in OUT, which was left with Ctrl-C or whose coppice was killed, and go on with it");
  command.add_flag("--print", arguments.print,
                   "With --slurm: print the script of the tasks instead of submitting it, for other schedulers; --attach then follows it");
  command
      .add_option("--coppice", arguments.coppice, "With --slurm: where the nodes have this program; by default where this machine has it")
      ->type_name("PATH");
  command.add_option("sbatch", arguments.sbatch_options, "With --slurm, after --: options of sbatch, as in -- -p long --mem 8G")
      ->type_name("-- OPTION ...");
}

std::string sbatch_hint(const std::vector<std::string>& words) {
  const auto has = [&words](const char* word) { return std::ranges::find(words, word) != words.end(); };
  return has("--slurm") && !has("--") ? "Options of sbatch follow --, as in --slurm -- -p long\n" : "";
}

std::string scancel_command(const std::vector<std::string>& jobs) {
  std::string text = "scancel";
  for (const std::string& job : jobs) text += " " + printable(job);
  return text;
}

void check_farm_arguments(const FarmArguments& arguments) {
  if (arguments.slurm && arguments.attach) throw CLI::ValidationError("--attach", "goes on with a run, --slurm starts one: not both");
  if (const std::string_view word = reserved_option(arguments.sbatch_options); !word.empty())
    throw CLI::ValidationError(std::string(word),
                               "name, array and cluster of the tasks are coppice's: by them it finds them again, and waits for them");
  if (arguments.slurm) return;
  if (arguments.print) throw CLI::ValidationError("--print", "needs --slurm");
  if (!arguments.coppice.empty()) throw CLI::ValidationError("--coppice", "needs --slurm");
  if (!arguments.sbatch_options.empty())
    throw CLI::ValidationError(arguments.sbatch_options.front(), "one input too many; options of sbatch need --slurm");
}

Result<void> refuse_beside_run(const fs::path& output_folder) {
  const auto folder = newest_run(output_folder);
  std::error_code error;
  if (!folder || fs::exists(report_path(*folder), error)) return {};
  COPPICE_TRY(run, read_run(*folder));
  if (run.submitter == Submitter::hand) return {};
  COPPICE_TRY(submissions, read_submissions(run));
  const auto queue = ask_slurm(run, submissions, {});
  if (!queue)
    return Error{queue.error().status, "a run on the cluster has not told its end", Error::kNoOffset,
                 folder->string() + ", which may be deleted if it has ended: " + queue.error().message()};
  if (!has_live(*queue)) return {};
  return Error{Status::invalid_argument, "a run on the cluster has not ended", Error::kNoOffset,
               folder->string() + "; --attach takes it up, " + scancel_command(jobs_of(submissions)) + " ends it"};
}

Result<fs::path> prepare_run(const FarmBatch& batch, const FarmArguments& arguments) {
  COPPICE_CHECK(refuse_beside_run(batch.output_folder));
  COPPICE_CHECK(check_words(batch, arguments));
  COPPICE_TRY(folder, make_run_folder(batch.output_folder));
  COPPICE_TRY(run, run_of(batch, arguments, folder));
  COPPICE_CHECK(load_plants(batch, run));
  COPPICE_CHECK(write_plan(run));
  COPPICE_CHECK(write_run(run));
  return folder;
}

Result<std::string> run_script(const fs::path& run_folder) {
  COPPICE_TRY(run, read_run(run_folder));
  COPPICE_TRY(submissions, read_submissions(run));
  return submissions.empty() ? std::string() : script_text(run, submissions.front());
}

Result<FollowedRun> follow(const fs::path& run_folder, bool is_new, bool quiet) {
  COPPICE_TRY(run, read_run(run_folder));
  ProgressBar bar(quiet ? ProgressBar::Visibility::never : ProgressBar::Visibility::on_terminal);
  FollowOptions options;
  options.progress = [&bar](const FarmStatus& status) { bar.show("bake-all", status.fraction, status_text(status)); };
  options.say = [&bar](const std::string& line) {
    bar.clear();
    std::fprintf(stderr, "coppice: %s\n", printable(line).c_str());
  };
  bool is_handed_over = false;
  options.submitted = [&](const Submission& submission) {
    is_handed_over = true;
    if (quiet) return;
    bar.clear();
    std::fprintf(stderr, "coppice: %zu %s wait or run as job %s; %s ends it\n", submission.tasks.size(),
                 submission.tasks.size() == 1 ? "task" : "tasks", printable(submission.job).c_str(),
                 scancel_command({submission.job}).c_str());
  };
  options.is_stopped = [] { return interrupted != 0; };
  const LeaveOnInterrupt leave;
  auto results = follow_run(run, options);
  bar.clear();
  if (!results) {
    // What failed by a file or the network may have reached the scheduler all the same.
    std::error_code error;
    if (is_new && !is_handed_over && results.error().status != Status::io) fs::remove_all(run_folder, error);
    return results.error();
  }
  FollowedRun followed;
  followed.left = results->end == FollowEnd::left;
  followed.folder = run_folder;
  COPPICE_TRY(submissions, read_submissions(run));
  followed.jobs = jobs_of(submissions);
  followed.batch = batch_of(run, *std::move(results));
  if (followed.batch.task_count == 0) followed.batch.seconds = since_made(run);
  take_reported(report_path(run_folder), followed.batch);
  if (!followed.left) {
    const std::string json = batch_json(followed.batch);
    COPPICE_CHECK(write_file_atomically(report_path(run_folder), bytes_of(json)));
  }
  return followed;
}

}  // namespace coppice::bake
