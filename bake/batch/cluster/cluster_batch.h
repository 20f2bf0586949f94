#pragma once

// A batch on the nodes of a Slurm cluster. Its tasks are `coppice bake-all` with a list of plants each. All that is known of a run is in
// files, so that the same command takes up where the one before it was stopped or killed:
//
//   OUT/.coppice-cluster/lock    held by the command that submits and waits
//   OUT/.coppice-cluster/NAME/   an array of tasks, NAME its name for Slurm: run.sh, and for task N the list N.json, the journal N.jsonl
//                                and the log N.log

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bake_batch.h"
#include "result.h"

namespace coppice::bake {

/// A batch for a cluster, and who hears of it.
struct ClusterBatch {
  std::filesystem::path output_folder;               ///< absolute
  std::filesystem::path coppice;                     ///< the program's path on the nodes
  std::vector<BatchPlant> plants;                    ///< checked and expanded, with their costs
  std::vector<std::string> entries;                  ///< for each plant, its entry of a list of bake-all
  std::vector<std::string> task_options;             ///< those that bake-all has in every task
  std::vector<std::string> sbatch_options;           ///< the user's
  BatchOptions options;                              ///< look_up_only: the caches that are asked before there are tasks
  std::function<void(const BatchStatus&)> progress;  ///< BatchStatus::running says how many tasks run and why others wait
  std::function<void(const std::string&)> say;       ///< a line for a person: what was submitted, what is waited for
  std::function<void(const std::string&)> warn;      ///< likewise: what was lost
  std::function<bool()> is_stopped;                  ///< the user leaves
};

/// Bakes the plants that no cache has. Where tasks of an earlier command are still in the queue, waits for them first. Submits one array of
/// tasks, waits for its end, and submits what is missing again with twice the memory and time, in at most three arrays. A plant that fails
/// by its own fault is not tried again. Tasks that somebody cancelled are not either.
/// returns  results in the order of the plants, or nothing where the user left: the tasks go on
/// errors   those of bake_batch and submit_array; io: the folder cannot be used, another command waits for this batch, or Slurm's
///          controller has not answered for ten minutes
/// thread   as bake_batch
Result<std::optional<std::vector<BatchResult>>> bake_on_cluster(const ClusterBatch& batch);

/// Writes the lists of all plants and returns the script of their tasks, for other schedulers: it takes the number of a task. Empty where
/// no plant can be baked. errors  io
Result<std::string> write_tasks(const ClusterBatch& batch);

}  // namespace coppice::bake
