#include "slurm.h"

#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <regex>
#include <sstream>

#include "printable.h"
#include "temporary_file.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

/// What a program prints, errors too. input: what it reads from its standard input
/// errors  unsupported: it is missing; `refusal` and `what`, with all that it prints: it fails
Result<std::string> output_of(const std::vector<std::string>& words, Status refusal, const char* what, const std::string& input = {}) {
  constexpr int kNoSuchProgram = 127;  // the shell's exit code
  // What a person likes squeue to show, as SQUEUE_PARTITION has it, is not what is asked here.
  const std::string command = R"(exec 2>&1; for name in $(env | sed -n 's/^\(SQUEUE_[^=]*\)=.*/\1/p'); do unset "$name"; done; )";
  // NOLINTNEXTLINE(cert-env33-c): shell_command() quotes every word
  std::FILE* pipe = ::popen((command + shell_command({"printf", "%s", input}) + " | " + shell_command(words)).c_str(), "re");
  if (pipe == nullptr) return system_error("cannot start", "/bin/sh", errno);
  std::string output;
  std::array<char, 4096> block{};
  for (std::size_t count = 0; (count = std::fread(block.data(), 1, block.size(), pipe)) > 0;) output.append(block.data(), count);
  const int end = ::pclose(pipe);
  if (WIFEXITED(end) && WEXITSTATUS(end) == kNoSuchProgram)
    return Error{Status::unsupported, "Slurm's programs are missing (Debian's package slurm-client)", Error::kNoOffset, words.front()};
  if (end != 0) return Error{refusal, what, Error::kNoOffset, printable(output)};
  return output;
}

}  // namespace

std::string shell_command(const std::vector<std::string>& words) {
  std::string command;
  for (const std::string& word : words)
    command += (command.empty() ? "'" : " '") + std::regex_replace(word, std::regex("'"), R"('\'')") + "'";
  return command;
}

std::string refused_sbatch_option(const std::vector<std::string>& options) {
  static const std::regex form("(-[MW]).*|(--clusters|--wait|--wrap)(=.*)?");
  std::smatch found;
  for (const std::string& word : options)
    if (std::regex_match(word, found, form)) return found.str(1) + found.str(2);
  return {};
}

bool chooses_memory(const std::vector<std::string>& options) {
  static const std::regex form("--mem(-per-[cg]pu)?(=.*)?");
  for (const char* variable : {"SBATCH_MEM_PER_NODE", "SBATCH_MEM_PER_CPU", "SBATCH_MEM_PER_GPU"})
    if (std::getenv(variable) != nullptr) return true;
  return std::ranges::any_of(options, [](const std::string& word) { return std::regex_match(word, form); });
}

std::uint32_t processors_of_task(const std::vector<std::string>& options) {
  static const std::regex form(" (?:-c ?|--cpus-per-task[= ])([0-9]{1,6})(?= )");
  std::string words = " ";
  for (const std::string& word : options) words += word + " ";
  std::uint32_t count = 1;
  for (std::sregex_iterator found(words.begin(), words.end(), form), end; found != end; ++found)
    count = std::max(1u, number_of<std::uint32_t>(found->str(1)).value_or(1));
  return count;
}

Result<std::string> submit_array(const std::string& script, const std::string& job_name, std::size_t task_count,
                                 const std::vector<std::string>& options) {
  // Where an option is given twice, the last counts.
  std::vector<std::string> words{"sbatch", "--parsable"};
  words.insert(words.end(), options.begin(), options.end());
  words.insert(words.end(), {"--job-name=" + job_name, "--array=0-" + std::to_string(task_count - 1)});
  // Not by its path: others may write to the output folder.
  COPPICE_TRY(output, output_of(words, Status::invalid_argument, "sbatch refuses the tasks", script));
  return output.substr(0, output.find_first_of(";\n"));
}

JobState parse_job_state(std::string_view lines) {
  static const std::regex form(R"((\d+)\|(?:(PENDING)|(BOOT_FAIL|CANCELLED|COMPLETED|DEADLINE|FAILED|NODE_FAIL|OUT_OF_MEMORY|PREEMPTED|)"
                               R"(REVOKED|TIMEOUT)|[^|]*)\|(.*))");
  JobState job;
  std::istringstream text{std::string(lines)};
  std::smatch fields;
  for (std::string line; std::getline(text, line);) {
    const auto task = std::regex_match(line, fields, form) ? number_of<std::uint32_t>(fields.str(1)) : std::nullopt;
    if (!task) continue;
    if (fields[2].matched) {
      ++job.pending;
      job.reason = fields[4];
    } else if (fields[3].matched) {
      job.ended[*task] = fields[3];
    } else {
      ++job.running;
    }
  }
  return job;
}

Result<JobState> query_job(const std::string& job_name) {
  COPPICE_TRY(lines, output_of({"squeue", "--array", "--noheader", "--states=all", "--name=" + job_name, "--format=%K|%T|%r"}, Status::io,
                               "Slurm's controller does not answer"));
  return parse_job_state(lines);
}

std::uint32_t slurm_processor_count() {
  // Allocated, idle, other, total; warnings come before.
  const auto counts = output_of({"sinfo", "--noheader", "--format=%C"}, Status::io, "Slurm's controller does not answer");
  const std::string text = counts ? counts->substr(0, counts->find_last_not_of('\n') + 1) : std::string();
  return number_of<std::uint32_t>(text.substr(text.rfind('/') + 1)).value_or(0);
}

}  // namespace coppice::bake
