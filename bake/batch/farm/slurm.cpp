#include "slurm.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>

#include "child_program.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

constexpr double kMostSeconds = 90.0;  // clients of Slurm ask again by themselves for about a minute

/// One of Slurm's programs. Variables that choose what squeue and sinfo show would hide tasks of ours, and another cluster is not asked.
Result<ProgramEnd> run_client(const std::vector<std::string>& words, const std::function<bool()>& waiting = {}) {
  constexpr std::array<std::string_view, 4> kHidden{"SQUEUE_", "SINFO_", "SBATCH_CLUSTERS=", "SLURM_CLUSTERS="};
  return run_program(words, kMostSeconds, waiting, kHidden);
}

/// Nothing here can do without Slurm's programs.
Error without_slurm(const Error& error) {
  return Error{Status::unsupported, error.what, Error::kNoOffset,
               error.detail + ": a machine that submits needs Slurm's client programs (Debian: slurm-client), and its slurm.conf"};
}

/// What a program said, as one line.
std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at)) text.replace(at, 1, "; ");
  return text;
}

/// Whether it is no word of the controller's, which may have taken the tasks all the same.
bool is_about_the_way(std::string_view said) {
  constexpr std::array<std::string_view, 5> kWords{"timed out", "Unable to contact", "Zero Bytes", "Communication", "Connection"};
  return std::ranges::any_of(kWords, [said](std::string_view words) { return said.find(words) != std::string_view::npos; });
}

bool is_live_state(std::string_view state) {
  constexpr std::array<std::string_view, 13> kLive{"PENDING",   "RUNNING",  "SUSPENDED",    "COMPLETING",   "CONFIGURING",
                                                   "RESIZING",  "REQUEUED", "REQUEUE_FED",  "REQUEUE_HOLD", "SIGNALING",
                                                   "STAGE_OUT", "STOPPED",  "RESV_DEL_HOLD"};
  return std::ranges::find(kLive, state) != kLive.end();
}

}  // namespace

Result<std::string> submit_to_slurm(const FarmRun& run, const Submission& submission, const std::function<bool()>& waiting) {
  std::vector<std::string> words{"sbatch", "--parsable"};
  words.insert(words.end(), run.sbatch_options.begin(), run.sbatch_options.end());
  // The script says so too, but variables like SBATCH_JOB_NAME go before it; the command line goes before them.
  words.push_back("--job-name=" + job_name(run, submission));
  words.push_back("--array=0-" + std::to_string(submission.tasks.size() - 1));
  words.push_back(script_path(run, submission).string());
  const auto end = run_client(words, waiting);
  if (!end) return without_slurm(end.error());
  // "123" or "123;cluster"
  const std::string job = end->out.substr(0, end->out.find_first_of(";\n"));
  if (end->exit_code == 0 && !job.empty()) return job;
  std::string said = one_line(end->err + end->out);
  if (said.find("Memory specification") != std::string::npos) said += "; where nodes have no RealMemory, add -- --mem=0";
  if (end->exit_code < 0 || said.empty() || is_about_the_way(said))
    return Error{Status::io, "sbatch does not say whether the tasks are taken", Error::kNoOffset,
                 (said.empty() ? script_path(run, submission).string() : said) + "; --attach looks for them again"};
  return Error{Status::invalid_argument, "sbatch refuses the tasks", Error::kNoOffset, said};
}

bool read_queue_line(const std::string& line, const FarmRun& run, Queue& queue) {
  std::array<std::string, 6> fields;
  std::istringstream text(line);
  for (std::string& field : fields)
    if (!std::getline(text, field, '|')) return false;
  const std::string start = "coppice-" + run.folder.filename().string() + "-";
  if (!fields[4].starts_with(start)) return false;
  const auto submission = number_of<std::uint32_t>(std::string_view(fields[4]).substr(start.size()));
  const auto task = number_of<std::uint32_t>(fields[1]);
  if (!submission || !task) return false;
  QueuedTask queued{
      fields[0], fields[2], fields[3], fields[5], is_live_state(fields[2]), fields[2] == "RUNNING" || fields[2] == "COMPLETING"};
  // A submission that was made twice has two tasks of a number: the one that lives counts.
  QueuedTask& there = queue[{*submission, *task}];
  if (!there.is_live || queued.is_live) there = std::move(queued);
  return true;
}

Result<Queue> ask_slurm(const FarmRun& run, const std::vector<Submission>& submissions, const std::function<bool()>& waiting) {
  std::string names;
  for (const Submission& submission : submissions) names += (names.empty() ? "" : ",") + job_name(run, submission);
  const auto end =
      run_client({"squeue", "--noheader", "--array", "--all", "--states=all", "--name=" + names, "--format=%F|%K|%T|%N|%j|%r"}, waiting);
  if (!end) return without_slurm(end.error());
  if (end->exit_code != 0) return Error{Status::io, "Slurm's controller does not answer", Error::kNoOffset, one_line(end->err)};
  Queue queue;
  std::istringstream lines(end->out);
  for (std::string line; std::getline(lines, line);) static_cast<void>(read_queue_line(line, run, queue));
  return queue;
}

bool has_too_much_time(const QueuedTask& task) {
  return task.is_live && !task.runs && (task.reason == "PartitionTimeLimit" || task.reason.find("MaxWall") != std::string::npos);
}

void cancel_waiting(const std::string& job) {
  static_cast<void>(run_client({"scancel", "--state=PENDING", job}));
}

bool has_live(const Queue& queue) {
  return std::ranges::any_of(queue, [](const auto& task) { return task.second.is_live; });
}

std::uint32_t slurm_processor_count() {
  const auto end = run_client({"sinfo", "--noheader", "--format=%C"});
  if (!end || end->exit_code != 0) return 0;
  // "allocated/idle/other/total"
  std::istringstream text(end->out);
  std::string allocated, idle;
  std::getline(std::getline(text, allocated, '/'), idle, '/');
  return number_of<std::uint32_t>(allocated).value_or(0) + number_of<std::uint32_t>(idle).value_or(0);
}

}  // namespace coppice::bake
