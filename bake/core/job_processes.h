#pragma once

// Jobs as processes of their own: one that crashes, or for which there is not enough memory, takes no other with it.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace coppice::bake {

/// How a job ended.
struct JobEnd {
  std::string result;   ///< what it returned, when `failure` is empty
  std::string failure;  ///< that it threw, or what ended its process
  std::uint64_t peak_rss_bytes = 0;
  bool lost = false;  ///< something else ended the process or kept it from starting: the same job may succeed elsewhere
};

/// Reports a fraction in [0, 1].
using JobProgress = std::function<void(double fraction)>;

struct JobCallbacks {
  /// Runs in the job's own process, a copy of the caller's as it was when the job started.
  std::function<std::string(std::size_t job, const JobProgress& progress)> run;
  std::function<void(std::size_t job, double fraction)> progressed = {};  ///< may be empty
  std::function<void(std::size_t job, JobEnd end)> ended;
};

/// What each job's process may take; 0 for no limit.
struct JobLimits {
  std::uint64_t memory_bytes = 0;  ///< heap and stacks, in the sense of RLIMIT_DATA
  double seconds = 0.0;            ///< from the start of the job
};

/// In a job whose memory is limited, what to add to a message that it ran out; empty elsewhere.
std::string memory_limit_hint();

/// Runs jobs 0 .. count - 1, started in this order, at most `at_a_time` >= 1 of them at once; back when all have ended. When the calling
/// process dies, so do they. A job that reaches a limit fails, wherever it is, and `failure` names the option to raise (--max-memory-mb,
/// --max-seconds). `progressed` and `ended` are called from the calling thread.
/// thread  the process must have no other threads, TBB's included: only the calling one is copied
void run_jobs(std::size_t count, std::size_t at_a_time, const JobCallbacks& callbacks, const JobLimits& limits = {});

}  // namespace coppice::bake
