#pragma once

// How much memory and time a command may take: for services that run it on what strangers send.

#include <filesystem>
#include <functional>
#include <vector>

#include "job_processes.h"

namespace CLI {
class App;
}

namespace coppice::bake {

struct LimitArguments {
  std::uint64_t max_memory_mb = 0;  ///< 10^6 bytes; 0: no limit
  double max_seconds = 0.0;         ///< 0: no limit
};

/// Adds --max-memory-mb and --max-seconds. `arguments` must outlive the command.
void add_limit_options(CLI::App& command, LimitArguments& arguments);

JobLimits job_limits(const LimitArguments& arguments);

/// Runs a command and returns its exit code. With a limit it runs in a process of its own, which is ended where it reaches the limit; then
/// prints which, removes the temporaries beside the outputs and returns 1.
/// file     what messages are about
/// outputs  files that the command may write; empty paths are skipped
/// thread   as run_jobs
int run_limited(const LimitArguments& arguments, const std::filesystem::path& file, const std::vector<std::filesystem::path>& outputs,
                const std::function<int()>& command);

}  // namespace coppice::bake
