#include "slurm.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <sstream>

#include "printable.h"
#include "temporary_file.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

constexpr int kNoSuchProgram = 127;  // the shell's exit code

struct ProgramEnd {
  int exit_code = -1;
  std::string output;
};

/// The shell's standard error goes to the terminal unless `command` says otherwise.
Result<ProgramEnd> run_shell(const std::string& command) {
  ProgramEnd end;
  std::FILE* pipe = ::popen(command.c_str(), "re");
  if (pipe == nullptr) return system_error("cannot start", "/bin/sh", errno);
  std::array<char, 4096> block{};
  for (std::size_t count = 0; (count = std::fread(block.data(), 1, block.size(), pipe)) > 0;) end.output.append(block.data(), count);
  const int status = ::pclose(pipe);
  end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return end;
}

/// What a person likes squeue to show, as SQUEUE_PARTITION has it, is not what is asked here.
void unset_preferences() {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable)
    if (const std::string_view text = *variable; text.starts_with("SQUEUE_")) variables.emplace_back(text.substr(0, text.find('=')));
  for (const std::string& variable : variables) ::unsetenv(variable.c_str());
}

Error not_installed(const char* program) {
  return Error{Status::unsupported, "Slurm's programs are missing (Debian's package slurm-client)", Error::kNoOffset, program};
}

bool names(std::string_view word, std::string_view option) {
  const bool is_long = option.starts_with("--");
  return word == option || (word.starts_with(option) && (!is_long || word[option.size()] == '='));
}

}  // namespace

std::string shell_command(const std::vector<std::string>& words) {
  std::string command;
  for (const std::string& word : words) {
    command += command.empty() ? "'" : " '";
    for (const char c : word) c == '\'' ? command += "'\\''" : command += c;
    command += '\'';
  }
  return command;
}

std::string_view refused_sbatch_option(const std::vector<std::string>& options) {
  for (const std::string& word : options)
    for (const std::string_view option : {"-M", "--clusters", "-W", "--wait", "--wrap"})
      if (names(word, option)) return option;
  return {};
}

bool chooses_memory(const std::vector<std::string>& options) {
  for (const char* variable : {"SBATCH_MEM_PER_NODE", "SBATCH_MEM_PER_CPU", "SBATCH_MEM_PER_GPU"})
    if (std::getenv(variable) != nullptr) return true;
  return std::ranges::any_of(options, [](const std::string& word) {
    return std::ranges::any_of(std::array{"--mem", "--mem-per-cpu", "--mem-per-gpu"},
                               [&](const char* option) { return names(word, option); });
  });
}

Result<std::string> submit_array(const std::filesystem::path& script, const std::string& job_name, std::size_t task_count,
                                 const std::vector<std::string>& options) {
  // Of an option that is given twice the last counts.
  std::vector<std::string> words{"sbatch", "--parsable"};
  words.insert(words.end(), options.begin(), options.end());
  words.insert(words.end(), {"--job-name=" + job_name, "--array=0-" + std::to_string(task_count - 1), script.string()});
  COPPICE_TRY(end, run_shell("exec 2>&1; " + shell_command(words)));
  if (end.exit_code == kNoSuchProgram) return not_installed("sbatch");
  if (end.exit_code != 0) return Error{Status::invalid_argument, "sbatch refuses the tasks", Error::kNoOffset, printable(end.output)};
  return end.output.substr(0, end.output.find_first_of(";\n"));
}

JobState parse_job_state(std::string_view lines) {
  constexpr std::array kEnds{"BOOT_FAIL", "CANCELLED",     "COMPLETED", "DEADLINE", "FAILED",
                             "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED", "REVOKED",  "TIMEOUT"};
  JobState job;
  std::istringstream text{std::string(lines)};
  for (std::string line, number, state, reason; std::getline(text, line);) {
    std::istringstream fields(line);
    std::getline(fields, number, '|');
    std::getline(fields, state, '|');
    const auto task = number_of<std::uint32_t>(number);
    if (!task || !std::getline(fields, reason)) continue;
    if (std::ranges::find(kEnds, state) != kEnds.end()) {
      job.ended[*task] = state;
    } else if (state == "PENDING") {
      ++job.pending;
      job.reason = reason;
    } else {
      ++job.running;
    }
  }
  return job;
}

Result<JobState> query_job(const std::string& job_name) {
  unset_preferences();
  COPPICE_TRY(end, run_shell("exec 2>&1; " + shell_command({"squeue", "--array", "--noheader", "--states=all", "--name=" + job_name,
                                                            "--format=%K|%T|%r"})));
  if (end.exit_code == kNoSuchProgram) return not_installed("squeue");
  if (end.exit_code != 0) return Error{Status::io, "Slurm's controller does not answer", Error::kNoOffset, printable(end.output)};
  return parse_job_state(end.output);
}

std::uint32_t slurm_processor_count() {
  // Allocated, idle, other, total.
  const auto end = run_shell(shell_command({"sinfo", "--noheader", "--format=%C"}) + " 2> /dev/null");
  const std::string text = end && end->exit_code == 0 ? end->output.substr(0, end->output.find('\n')) : std::string();
  return number_of<std::uint32_t>(text.substr(text.rfind('/') + 1)).value_or(0);
}

}  // namespace coppice::bake
