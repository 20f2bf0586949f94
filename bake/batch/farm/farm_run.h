#pragma once

// The folder of a run on a cluster, OUT/.coppice-farm/RUN/. All that is known of a run is in its files, which the submitter, its successor
// and the tasks share; nobody has to keep anything in memory, and whoever reads them goes on where the last one was.
//
//   run.json                 the plants and how they are baked; written last of what a run begins with: without it there is no run
//   submission-001.json      which plants are in which task, limits, and once the scheduler has it, its job; .sh: what each task runs
//   task-001-0017.json       the list of plants of task 17 of submission 1, for `coppice bake-all`
//   tries/001-0017.JOB.HOST.PROCESS.start   written by a task when it starts: where and when; .plants: its journal; .log: what it
//                            printed; .report: what bake-all --report writes; .end: its exit code and when. Two tries of one task, which a
//                            scheduler may start, share no file
//   submitter.jsonl          journal of what no task tells: plants that were cached before, and those that were given up
//   cache-gave-up            the shared cache on a server was of no use to somebody, and no more tasks ask it
//   report.json              the end: what `--report` writes

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "farm_plan.h"
#include "plant_cost.h"
#include "remote_cache.h"
#include "result.h"

namespace coppice::bake {

/// A plant as tasks get it.
struct FarmPlant {
  std::filesystem::path input, output;  ///< absolute
  std::string list_entry;               ///< JSON: the entry of a list of bake-all, with every option
  PlantCost cost;
  std::string failure;     ///< why it is not baked; empty
  bool is_cached = false;  ///< found before: in the submitter's journal, not given to any task
};

enum class Submitter : std::uint8_t {
  slurm,
  hand  ///< somebody else starts the tasks, after --print
};

struct FarmRun {
  std::filesystem::path folder, output_folder;  ///< absolute
  std::filesystem::path coppice;                ///< of the nodes
  Submitter submitter = Submitter::slurm;
  std::vector<std::string> sbatch_options;  ///< the user's
  std::vector<std::string> task_options;    ///< of bake-all, for every task
  std::vector<std::string> server_options;  ///< likewise, of a cache on a server, as long as it is of use; empty: there is none
  std::uint32_t most_attempts = 3;          ///< of a plant
  std::vector<FarmPlant> plants;
  CacheReport cache;  ///< what the shared cache did before there were tasks
};

/// An array of tasks, given to the scheduler in one go.
struct Submission {
  std::uint32_t number = 1;   ///< 1 ..
  std::uint32_t attempt = 1;  ///< the plants' so manieth
  std::uint64_t memory_bytes = 0;
  std::uint32_t minutes = 0;
  std::vector<FarmTask> tasks;
  std::string job;                          ///< the scheduler's number; empty: it may not have it
  double submitted_s = 0.0;                 ///< seconds since 1970
  std::string refused;                      ///< why the scheduler did not take it; empty
  std::string because;                      ///< why its plants are tried again; empty of the first attempt
  std::vector<std::string> excluded_nodes;  ///< where no task can do anything
};

/// OUT/.coppice-farm
std::filesystem::path farm_folder(const std::filesystem::path& output_folder);

/// Makes a folder for a run, by whose name the scheduler tells its jobs from all others: the time, and a number that nobody else has.
/// errors  io
Result<std::filesystem::path> make_run_folder(const std::filesystem::path& output_folder);

/// The newest run of an output folder. errors  invalid_argument: there is none
Result<std::filesystem::path> newest_run(const std::filesystem::path& output_folder);

/// Writes run.json. errors  io
Result<void> write_run(const FarmRun& run);
/// errors  io, bad_file
Result<FarmRun> read_run(const std::filesystem::path& folder);

/// Writes a submission's lists, then its script, then its record. errors  io
Result<void> write_submission(const FarmRun& run, const Submission& submission);
/// Writes the record alone: what the scheduler said of it. errors  io
Result<void> write_record(const FarmRun& run, const Submission& submission);
/// All of a run, in order. errors  io, bad_file
Result<std::vector<Submission>> read_submissions(const FarmRun& run);

/// What a task runs, with what Slurm reads in its comments.
std::string script_text(const FarmRun& run, const Submission& submission);
std::filesystem::path script_path(const FarmRun& run, const Submission& submission);
/// Names the submission to the scheduler: "coppice-RUN-1".
std::string job_name(const FarmRun& run, const Submission& submission);

/// There once the shared cache was given up.
std::filesystem::path cache_given_up_path(const std::filesystem::path& run_folder);

std::filesystem::path submitter_journal(const std::filesystem::path& run_folder);

/// Where a run's report is; it has ended when that is there.
std::filesystem::path report_path(const std::filesystem::path& run_folder);

/// Keeps a second submitter from following a run, for as long as it lives.
class RunLock {
 public:
  /// errors  io: another process has it, or it cannot be used
  static Result<RunLock> take(const std::filesystem::path& run_folder);
  RunLock(RunLock&& other) noexcept;
  RunLock& operator=(RunLock&&) = delete;
  ~RunLock();

 private:
  explicit RunLock(int file) : file_(file) {}
  int file_;
};

}  // namespace coppice::bake
