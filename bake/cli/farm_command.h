#pragma once

// bake-all on a cluster: its options, and how a batch becomes a run and a run a batch.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "batch_report.h"
#include "result.h"

namespace CLI {
class App;
}

namespace coppice::bake {

struct FarmArguments {
  bool slurm = false, attach = false, print = false;
  std::filesystem::path coppice;
  std::vector<std::string> sbatch_options;
};

/// Adds --slurm, --attach, --print, --coppice and what follows "--". `arguments` must outlive the command.
void add_farm_options(CLI::App& command, FarmArguments& arguments);

/// A line for a command line that was refused, where it lacks the -- before options of sbatch; empty.
std::string sbatch_hint(const std::vector<std::string>& words);

/// "scancel 45 46"
std::string scancel_command(const std::vector<std::string>& jobs);

/// Throws CLI::ValidationError for options that do not go together.
void check_farm_arguments(const FarmArguments& arguments);

/// A batch for a cluster.
struct FarmBatch {
  std::filesystem::path output_folder;      ///< absolute
  std::vector<BatchPlant> plants;           ///< checked, expanded
  std::vector<std::string> task_options;    ///< of bake-all, for each task
  std::vector<std::string> server_options;  ///< likewise, of a cache on a server; empty: there is none
  BatchOptions caches;                      ///< in which plants are looked for before there are tasks: as set_caches
};

/// Refuses what would write into a folder while tasks of a run on a cluster do. errors  invalid_argument
Result<void> refuse_beside_run(const std::filesystem::path& output_folder);

/// Makes a run of it. errors  io; invalid_argument: a path that JSON cannot hold, or tasks of another run still bake into this folder
Result<std::filesystem::path> prepare_run(const FarmBatch& batch, const FarmArguments& arguments);

/// The script of a run's only submission, for --print. errors  as read_run
Result<std::string> run_script(const std::filesystem::path& run_folder);

/// A run that was followed to its end, or left.
struct FollowedRun {
  Batch batch;
  bool left = false;
  std::filesystem::path folder;
  std::vector<std::string> jobs;  ///< that Slurm has of it
};

/// Follows a run with a progress bar and lines about what is lost, until it has ended or Ctrl-C is pressed. Writes its report.json. A new
/// run that Slurm refuses is removed.
/// errors  those of follow_run
Result<FollowedRun> follow(const std::filesystem::path& run_folder, bool is_new, bool quiet);

}  // namespace coppice::bake
