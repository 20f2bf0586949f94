#pragma once

// Submits a run's tasks, watches them, and gives those that were lost to the scheduler again, until every plant has ended. What it decides
// by is in files (farm_run.h), so that any process can do so after the one before was killed.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bake_batch.h"
#include "farm_run.h"
#include "result.h"

namespace coppice::bake {

/// What became of a plant, and where.
struct FarmPlantEnd {
  BatchResult result;
  std::string node;            ///< where it ended; empty: nowhere
  double queue_seconds = 0.0;  ///< how long its task waited to be started
  std::uint32_t attempts = 0;  ///< tasks that began with it
  std::string log_tail;        ///< of one that failed: the last lines that its last task printed
};

/// One run of a task, whether it ended or was lost.
struct FarmTry {
  std::uint32_t submission = 0, task = 0;
  std::string node;
  double start_s = 0.0;          ///< since the first submission, by the node's clock
  double seconds = 0.0;          ///< 0 where it has not told that it ended
  std::optional<int> exit_code;  ///< nothing: it was ended from outside, or has not ended
};

struct FarmStatus {
  std::size_t ended = 0, count = 0;      ///< plants
  double fraction = 0.0;                 ///< of all work, by the estimates
  std::size_t running = 0, waiting = 0;  ///< tasks
  std::string waits_for;                 ///< why one of them waits, in Slurm's word
  std::string note;                      ///< what keeps it from going on; empty
};

struct FollowOptions {
  std::function<void(const FarmStatus&)> progress;   ///< several times a second
  std::function<void(const std::string&)> say;       ///< a line for a person: what was lost and is tried again
  std::function<void(const Submission&)> submitted;  ///< the scheduler has one more
  std::function<bool()> is_stopped;                  ///< the user leaves
};

enum class FollowEnd : std::uint8_t { all_ended, left };

struct FarmResults {
  FollowEnd end = FollowEnd::all_ended;
  std::vector<FarmPlantEnd> plants;  ///< in the order of the run's
  std::size_t task_count = 0, retried_task_count = 0;
  std::size_t most_running = 0;  ///< tasks at a time, as far as was seen
  double seconds = 0.0;          ///< since the first submission
  std::vector<FarmTry> tries;    ///< by their start
};

/// errors  io: the run's folder cannot be used, or Slurm's controller does not take a new run; unsupported: Slurm's programs are missing;
///         invalid_argument: sbatch refuses the first tasks, with all that it says
Result<FarmResults> follow_run(const FarmRun& run, const FollowOptions& options);

/// Whether a plant failed because something took its process, rather than by its own fault: killed, as by a node whose memory ran out, out
/// of memory, or not even started. It is then tried again with more.
bool was_taken_away(const BatchResult& result);

}  // namespace coppice::bake
