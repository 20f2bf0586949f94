#include "farm_run.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <random>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "cache_report_json.h"
#include "sbatch_options.h"
#include "temporary_file.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kGivenUp = "cache-gave-up";
constexpr std::uint32_t kRunVersion = 1;  // of run.json

Result<void> write_text(const fs::path& path, const std::string& text) {
  return write_file_atomically(path, bytes_of(text));
}

std::string dumped(const Json& json) {
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<Json> read_json(const fs::path& path) {
  COPPICE_TRY(bytes, read_file(path));
  Json json = Json::parse(bytes.begin(), bytes.end(), nullptr, false);
  if (!json.is_object()) return Error{Status::bad_file, "not a file of coppice's", Error::kNoOffset, path.string()};
  return json;
}

std::string numbered(std::uint32_t number, int digits) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%0*u", digits, number);
  return text.data();
}

fs::path record_path(const FarmRun& run, std::uint32_t number) {
  return run.folder / ("submission-" + numbered(number, 3) + ".json");
}

/// In single quotes, as a shell reads it.
std::string shell_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text)
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += c;
  return quoted + "'";
}

/// A file name in double quotes, as sbatch reads it in a script: with % as itself.
std::string sbatch_file_name(const std::string& text) {
  std::string quoted;
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '%') quoted += '%';
    quoted += c;
  }
  return quoted;
}

Json list_of(const FarmRun& run, const FarmTask& task) {
  Json list = Json::array();
  for (const std::uint32_t plant : task.plants) list.push_back(Json::parse(run.plants[plant].list_entry));
  return list;
}

/// What Slurm reads. Its own options come first: of those that a user gives too, on the command line, the latter count.
std::string sbatch_lines(const FarmRun& run, const Submission& submission) {
  const auto line = [](const std::string& option) { return "#SBATCH --" + option + "\n"; };
  std::string text = line("job-name=" + job_name(run, submission));
  text += line("array=0-" + std::to_string(submission.tasks.size() - 1));
  text += line("nodes=1") + line("ntasks=1") + line("cpus-per-task=1");
  text += line("time=" + std::to_string(submission.minutes));
  const std::uint64_t bytes = submission.memory_bytes * processors_of_task(run.sbatch_options);
  if (!say_memory(run.sbatch_options)) text += line("mem=" + std::to_string(bytes / 1'000'000 + 1) + "M");
  std::string excluded;
  for (const std::string& node : submission.excluded_nodes) excluded += (excluded.empty() ? "" : ",") + node;
  if (!excluded.empty()) text += line("exclude=" + excluded);
  text += line("requeue") + line("open-mode=append");
  text += line("output=\"" + sbatch_file_name((run.folder / "slurm-").string()) + "%A_%a.out\"");
  return text;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += " " + shell_quoted(word);
  return text;
}

/// Leaves the options as "$@". A server that was of no use to one task is asked by no other: each would find that out anew.
std::string choice_of_cache(const FarmRun& run) {
  if (run.server_options.empty()) return "set --\n";
  return "if [ -e \"$run/" + std::string(kGivenUp) + "\" ]; then set -- --cache \"$out/" + kOwnCache + "\"; else set --" +
         joined(run.server_options) + "; fi\n";
}

Json plant_json(const FarmPlant& plant) {
  return {{"input", plant.input.string()},           {"output", plant.output.string()},         {"entry", plant.list_entry},
          {"milliseconds", plant.cost.milliseconds}, {"memory_bytes", plant.cost.memory_bytes}, {"failure", plant.failure}};
}

FarmPlant plant_of(const Json& json) {
  return {json.at("input").get<std::string>(),
          json.at("output").get<std::string>(),
          json.at("entry").get<std::string>(),
          {json.at("milliseconds").get<std::uint64_t>(), json.at("memory_bytes").get<std::uint64_t>()},
          json.at("failure").get<std::string>()};
}

FarmRun run_of(const Json& json, const fs::path& folder) {
  FarmRun run;
  run.folder = folder;
  run.output_folder = json.at("output_folder").get<std::string>();
  run.coppice = json.at("coppice").get<std::string>();
  run.submitter = json.at("by_hand").get<bool>() ? Submitter::hand : Submitter::slurm;
  run.sbatch_options = json.at("sbatch_options").get<std::vector<std::string>>();
  run.task_options = json.at("task_options").get<std::vector<std::string>>();
  run.server_options = json.at("server_options").get<std::vector<std::string>>();
  run.most_attempts = json.at("most_attempts").get<std::uint32_t>();
  for (const Json& plant : json.at("plants")) run.plants.push_back(plant_of(plant));
  run.cache = nlohmann::json(json.at("cache")).get<CacheReport>();
  return run;
}

Submission submission_of(const Json& json) {
  Submission submission;
  submission.number = json.at("number").get<std::uint32_t>();
  submission.attempt = json.at("attempt").get<std::uint32_t>();
  submission.memory_bytes = json.at("memory_bytes").get<std::uint64_t>();
  submission.minutes = json.at("minutes").get<std::uint32_t>();
  submission.job = json.at("job").get<std::string>();
  submission.submitted_s = json.at("submitted").get<double>();
  submission.refused = json.at("refused").get<std::string>();
  submission.because = json.at("because").get<std::string>();
  submission.excluded_nodes = json.at("excluded_nodes").get<std::vector<std::string>>();
  for (const Json& task : json.at("tasks")) submission.tasks.push_back({task.get<std::vector<std::uint32_t>>()});
  return submission;
}

Error damaged(const fs::path& path, const char* why) {
  return Error{Status::bad_file, "not a file of this version of coppice", Error::kNoOffset, path.string() + ": " + why};
}

}  // namespace

fs::path farm_folder(const fs::path& output_folder) {
  return output_folder / ".coppice-farm";
}

Result<fs::path> make_run_folder(const fs::path& output_folder) {
  const fs::path farm = farm_folder(output_folder);
  std::error_code error;
  fs::create_directories(farm, error);
  if (error) return system_error("cannot make the folder", farm, error.value());
  std::timespec now{};
  std::timespec_get(&now, TIME_UTC);
  std::tm calendar{};
  ::gmtime_r(&now.tv_sec, &calendar);
  std::array<char, 64> name{};
  const std::size_t bytes = std::strftime(name.data(), name.size(), "%Y%m%d-%H%M%S", &calendar);
  std::snprintf(name.data() + bytes, name.size() - bytes, "-%06ld-%08x", now.tv_nsec / 1000, std::random_device()());
  const fs::path folder = farm / name.data();
  for (const fs::path& made : {folder, folder / "tries"})
    if (!fs::create_directory(made, error)) return system_error("cannot make the folder", made, error ? error.value() : EEXIST);
  return folder;
}

Result<fs::path> newest_run(const fs::path& output_folder) {
  fs::path newest;
  std::error_code error;
  for (fs::directory_iterator entry(farm_folder(output_folder), error), end; !error && entry != end; entry.increment(error)) {
    std::error_code unreadable;
    if (entry->path() > newest && fs::exists(entry->path() / "run.json", unreadable)) newest = entry->path();
  }
  if (newest.empty())
    return Error{Status::invalid_argument, "no run on a cluster to take up; --slurm starts one", Error::kNoOffset, output_folder.string()};
  return newest;
}

fs::path report_path(const fs::path& run_folder) {
  return run_folder / "report.json";
}

fs::path cache_given_up_path(const fs::path& run_folder) {
  return run_folder / kGivenUp;
}

fs::path submitter_journal(const fs::path& run_folder) {
  return run_folder / "submitter.jsonl";
}

Result<void> write_run(const FarmRun& run) {
  Json plants = Json::array();
  for (const FarmPlant& plant : run.plants) plants.push_back(plant_json(plant));
  return write_text(run.folder / "run.json", dumped({{"version", kRunVersion},
                                                     {"output_folder", run.output_folder.string()},
                                                     {"coppice", run.coppice.string()},
                                                     {"by_hand", run.submitter == Submitter::hand},
                                                     {"sbatch_options", run.sbatch_options},
                                                     {"task_options", run.task_options},
                                                     {"server_options", run.server_options},
                                                     {"most_attempts", run.most_attempts},
                                                     {"plants", std::move(plants)},
                                                     {"cache", nlohmann::json(run.cache)}}));
}

Result<FarmRun> read_run(const fs::path& folder) {
  const fs::path path = folder / "run.json";
  COPPICE_TRY(json, read_json(path));
  try {
    if (json.at("version") != kRunVersion) return damaged(path, "version");
    return run_of(json, folder);
  } catch (const Json::exception& error) {
    return damaged(path, error.what());
  }
}

fs::path script_path(const FarmRun& run, const Submission& submission) {
  return run.folder / ("submission-" + numbered(submission.number, 3) + ".sh");
}

std::string job_name(const FarmRun& run, const Submission& submission) {
  return "coppice-" + run.folder.filename().string() + "-" + std::to_string(submission.number);
}

std::string script_text(const FarmRun& run, const Submission& submission) {
  const std::string last = std::to_string(submission.tasks.size() - 1), number = numbered(submission.number, 3);
  std::string text = "#!/bin/sh\n" + sbatch_lines(run, submission);
  text += "# Bakes a list of plants; the scheduler runs it once for each number from 0 to " + last +
          ". Slurm says the number itself: sbatch" + joined(run.sbatch_options) +
          " THIS\n# Any other scheduler, or a person: sh THIS NUMBER\n# What becomes of it: coppice bake-all -o " +
          shell_quoted(run.output_folder.string()) + " --attach\n";
  text += "run=" + shell_quoted(run.folder.string()) + "\nout=" + shell_quoted(run.output_folder.string()) +
          "\ncoppice=" + shell_quoted(run.coppice.string()) + "\n";
  text += R"(number=${1:-${SLURM_ARRAY_TASK_ID:?the number of a task from 0 to )" + last + "}}\n";
  text += R"(known=no
case $number in *[!0-9]* | 0?*) ;; *) [ "$number" -le )" +
          last + R"( ] && known=yes ;; esac
if [ $known = no ]; then
  echo "coppice: there is no task $number: they go from 0 to )" +
          last + R"(" >&2
  exit 2
fi
task=)" + number +
          R"(-$(printf %04d "$number")
)";
  text += R"(node=${SLURMD_NODENAME:-$(hostname)}
if ! [ -f "$run/task-$task.json" ]; then
  echo "coppice: $node does not see $run: OUT must be in a folder that all nodes share" >&2
  exit 66
fi
)" + choice_of_cache(run) +
          R"(# What becomes of the task is told by files, each whole or not there.
try=$run/tries/$task.${SLURM_JOB_ID:-0}.$(hostname).$$
tell() {
  printf '%s\n' "$2" > "$try.$1.new" && mv "$try.$1.new" "$try.$1"
}
tell start "{\"node\": \"$node\", \"job\": \"${SLURM_JOB_ID:-}\", \"array_job\": \"${SLURM_ARRAY_JOB_ID:-}\", \"restart\": ${SLURM_RESTART_COUNT:-0}, \"time\": $(date +%s.%N)}"
"$coppice" bake-all "$run/task-$task.json" -o "$out" --threads "${SLURM_CPUS_PER_TASK:-1}" --journal "$try.plants" --report "$try.report")" +
          joined(run.task_options) + R"( "$@" > "$try.log" 2>&1
code=$?
if grep -q '"gave_up": true' "$try.report" 2> /dev/null; then : > "$run/)" +
          kGivenUp + R"("; fi
tell end "{\"exit\": $code, \"time\": $(date +%s.%N)}"
exit $code
)";
  return text;
}

Result<void> write_record(const FarmRun& run, const Submission& submission) {
  Json tasks = Json::array();
  for (const FarmTask& task : submission.tasks) tasks.push_back(task.plants);
  return write_text(record_path(run, submission.number), dumped({{"number", submission.number},
                                                                 {"attempt", submission.attempt},
                                                                 {"memory_bytes", submission.memory_bytes},
                                                                 {"minutes", submission.minutes},
                                                                 {"job", submission.job},
                                                                 {"submitted", submission.submitted_s},
                                                                 {"refused", submission.refused},
                                                                 {"because", submission.because},
                                                                 {"excluded_nodes", submission.excluded_nodes},
                                                                 {"tasks", std::move(tasks)}}));
}

Result<void> write_submission(const FarmRun& run, const Submission& submission) {
  const std::string prefix = "task-" + numbered(submission.number, 3) + "-";
  for (std::uint32_t task = 0; task < submission.tasks.size(); ++task) {
    COPPICE_CHECK(write_text(run.folder / (prefix + numbered(task, 4) + ".json"), dumped(list_of(run, submission.tasks[task]))));
  }
  COPPICE_CHECK(write_text(script_path(run, submission), script_text(run, submission)));
  return write_record(run, submission);
}

Result<std::vector<Submission>> read_submissions(const FarmRun& run) {
  std::vector<Submission> submissions;
  std::error_code error;
  for (std::uint32_t number = 1; fs::exists(record_path(run, number), error); ++number) {
    COPPICE_TRY(json, read_json(record_path(run, number)));
    try {
      submissions.push_back(submission_of(json));
    } catch (const Json::exception& exception) {
      return damaged(record_path(run, number), exception.what());
    }
    for (const FarmTask& task : submissions.back().tasks)
      for (const std::uint32_t plant : task.plants)
        if (plant >= run.plants.size()) return damaged(record_path(run, number), "a task has a plant that is not in run.json");
  }
  return submissions;
}

Result<RunLock> RunLock::take(const fs::path& run_folder) {
  const fs::path path = run_folder / "follower";
  RunLock lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (lock.file_ < 0) return system_error("cannot use the run", path, errno);
  if (::flock(lock.file_, LOCK_EX | LOCK_NB) == 0) return lock;
  if (errno != EWOULDBLOCK) return system_error("cannot lock", path, errno);
  return Error{Status::io, "another coppice follows this run", Error::kNoOffset, run_folder.string()};
}

RunLock::RunLock(RunLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

RunLock::~RunLock() {
  if (file_ >= 0) ::close(file_);
}

}  // namespace coppice::bake
