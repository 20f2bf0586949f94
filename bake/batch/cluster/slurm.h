#pragma once

// The programs of Slurm that are used: sbatch, squeue and sinfo, by their machine-readable output. Slurm's accounting is not needed.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "result.h"

namespace coppice::bake {

/// Words as a POSIX shell reads them: each in single quotes, with spaces between.
std::string shell_command(const std::vector<std::string>& words);

/// The first option of sbatch that would keep coppice from finding its tasks again, as --clusters does; empty without one.
std::string refused_sbatch_option(const std::vector<std::string>& options);
/// Whether the user chooses the memory of tasks, by an option or in sbatch's environment: Slurm takes no two options for it.
bool chooses_memory(const std::vector<std::string>& options);
/// The processors of a task, of which the script asks for one: the value of the last --cpus-per-task; at least 1.
std::uint32_t processors_of_task(const std::vector<std::string>& options);

/// Submits a script, as text, as one array of tasks 0 .. task_count - 1 under a job's name.
/// returns  the job's number
/// errors   unsupported: there is no sbatch; invalid_argument: it refuses, with all that it says
Result<std::string> submit_array(const std::string& script, const std::string& job_name, std::size_t task_count,
                                 const std::vector<std::string>& options);

/// What Slurm knows of a job's tasks. It forgets those that ended some minutes ago.
struct JobState {
  std::uint32_t running = 0, pending = 0;
  std::string reason;                          ///< why one is pending, as Slurm names it: "Priority", "JobHeldUser"
  std::map<std::uint32_t, std::string> ended;  ///< by task: "COMPLETED", "OUT_OF_MEMORY", "CANCELLED"
  [[nodiscard]] bool is_live() const { return running + pending > 0; }
};

/// errors  unsupported: there is no squeue; io: the controller does not answer, which passes
Result<JobState> query_job(const std::string& job_name);

/// Lines of `squeue --array --noheader --format=%K|%T|%r`; others are skipped.
JobState parse_job_state(std::string_view lines);

/// Processors of the cluster; 0 where Slurm does not say.
std::uint32_t slurm_processor_count();

}  // namespace coppice::bake
