#include "bake_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "output.h"
#include "temporary_file.h"

namespace coppice::bake {

void add_bake_options(CLI::App& command, BakeRequest& request, std::initializer_list<OptionGroup> groups) {
  for (const BakeOption& option : bake_option_table()) {
    if (groups.size() > 0 && std::ranges::find(groups, option.group) == groups.end()) continue;
    const std::string name = "--" + option.name;
    const auto set = [&option, &request, name](const std::string& text) {
      if (const auto done = option.set(request, text); !done) throw CLI::ValidationError(name, done.error().detail);
    };
    if (option.type.empty()) {
      command.add_flag_callback(
          name, [set] { set("true"); }, option.help);
      continue;
    }
    CLI::Option* added = command.add_option_function<std::string>(name, set, option.help)->type_name(option.type);
    if (const auto value = option.get({})) added->default_str(*value);
  }
}

void add_count_option(CLI::App& command, const std::string& name, std::uint32_t& count, const std::string& help) {
  command.add_option(name, count, help)->check(CLI::Range(0, 1024))->type_name("N")->capture_default_str();
}

void check_bake_request(const BakeRequest& request) {
  if (const auto possible = check_areas(request.options); !possible) throw CLI::ValidationError("--areas", possible.error().what);
}

void add_limit_options(CLI::App& command, LimitArguments& arguments) {
  command.add_option("--max-memory-mb", arguments.max_memory_mb, "Give up a plant for which so many megabytes of memory do not suffice")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40))
      ->type_name("MB");
  command.add_option("--max-seconds", arguments.max_seconds, "Give up a plant that takes longer")
      ->check(CLI::Range(0.001, 1e9))
      ->type_name("S");
}

JobLimits job_limits(const LimitArguments& arguments) {
  return {arguments.max_memory_mb * 1'000'000, arguments.max_seconds};
}

int run_limited(const LimitArguments& arguments, const std::filesystem::path& file, const std::vector<std::filesystem::path>& outputs,
                const std::function<int()>& command) {
  if (arguments.max_memory_mb == 0 && arguments.max_seconds == 0.0) return command();
  int exit_code = 1;
  JobCallbacks callbacks;
  callbacks.run = [&](std::size_t, const JobProgress&) {
    const int code = command();
    // The job leaves without the exit handlers that would do so.
    return std::to_string(std::fflush(nullptr) == 0 ? code : 1);
  };
  callbacks.ended = [&](std::size_t, const JobEnd& end) {
    exit_code = end.failure.empty() ? std::stoi(end.result)
                                    : report_failure(file, Error{Status::internal, "given up", Error::kNoOffset, end.failure});
  };
  run_jobs(1, 1, callbacks, job_limits(arguments));
  for (const std::filesystem::path& output : outputs)
    if (!output.empty()) remove_abandoned_temporaries(folder_of(output));
  return exit_code;
}

}  // namespace coppice::bake
