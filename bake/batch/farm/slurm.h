#pragma once

// The programs of Slurm that are used: sbatch, squeue, sinfo and scancel. Its database, which not every site has, is not.

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "farm_run.h"
#include "result.h"

namespace coppice::bake {

/// Hands a submission over. waiting: as run_program has it.
/// returns  the job's number
/// errors   unsupported: there is no sbatch; invalid_argument: it refuses, with all that it says; io: it may have been taken or not
Result<std::string> submit_to_slurm(const FarmRun& run, const Submission& submission, const std::function<bool()>& waiting);

/// A task as Slurm has it.
struct QueuedTask {
  std::string job, state, node;
  std::string reason;    ///< why it waits, as Slurm names it: "Priority", "JobHeldUser"
  bool is_live = false;  ///< waits, runs or comes to its end, rather than remembered
  bool runs = false;
};

/// Whether it waits for ever, because it asks for more time than is allowed.
bool has_too_much_time(const QueuedTask& task);

/// Tasks by submission and task.
using Queue = std::map<std::pair<std::uint32_t, std::uint32_t>, QueuedTask>;

/// Takes a job's tasks that wait from the queue, if that can be done.
void cancel_waiting(const std::string& job);

/// Whether any task waits, runs or comes to its end.
bool has_live(const Queue& queue);

/// What Slurm knows of submissions' tasks: all that live, and those that ended minutes ago.
/// errors  unsupported: there is no squeue; io: the controller does not answer, which passes
Result<Queue> ask_slurm(const FarmRun& run, const std::vector<Submission>& submissions, const std::function<bool()>& waiting);

/// One line of `squeue --format=%F|%K|%T|%N|%j|%r`. false: it is none.
bool read_queue_line(const std::string& line, const FarmRun& run, Queue& queue);

/// Processors of the cluster that are up; 0 where Slurm does not say.
std::uint32_t slurm_processor_count();

}  // namespace coppice::bake
