#pragma once

// Arguments that several commands have: the options of bake_option_table(), and limits.

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "job_processes.h"
#include "option_table.h"

namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

namespace coppice::bake {

/// Adds the options of some groups, all without any. `request` gets what is given when the command is parsed, and must outlive the command.
void add_bake_options(CLI::App& command, BakeRequest& request, std::initializer_list<OptionGroup> groups = {});

/// Adds an option for a number of threads or processes, 0 to 1024.
void add_count_option(CLI::App& command, const std::string& name, std::uint32_t& count, const std::string& help);

/// Throws CLI::ValidationError for options that do not go together.
void check_bake_request(const BakeRequest& request);

/// How much memory and time a command may take: for services that run it on what strangers send.
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
