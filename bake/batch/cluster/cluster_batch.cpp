#include "cluster_batch.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>
#include <random>
#include <sstream>
#include <system_error>
#include <thread>
#include <utility>

#include "atomic_file.h"
#include "batch_plan.h"
#include "file_lock.h"
#include "plant_record.h"
#include "slurm.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kMaxAttempts = 3;
constexpr double kMaxSilence_s = 600.0;  // of Slurm's controller

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

fs::path cluster_folder(const ClusterBatch& batch) {
  return batch.output_folder / ".coppice-cluster";
}

/// An array of tasks.
struct Submission {
  fs::path folder;  ///< its name is the job's
  std::vector<PlantGroup> tasks;
  std::uint64_t memory_bytes = 0;  ///< of each processor
  std::uint64_t minutes = 0;

  [[nodiscard]] std::string name() const { return folder.filename().string(); }
  [[nodiscard]] fs::path file(std::size_t task, const char* extension) const { return folder / (std::to_string(task) + extension); }
};

Result<fs::path> make_folder(const ClusterBatch& batch) {
  std::array<char, 64> time{};
  const std::time_t now = std::time(nullptr);
  std::tm calendar{};
  if (::gmtime_r(&now, &calendar) != nullptr) static_cast<void>(std::strftime(time.data(), time.size(), "%Y%m%d-%H%M%S", &calendar));
  std::array<char, 96> name{};
  std::snprintf(name.data(), name.size(), "coppice-%s-%08x", time.data(), std::random_device()());
  fs::path folder = cluster_folder(batch) / name.data();
  COPPICE_CHECK(make_folder_of(folder / "run.sh"));
  return folder;
}

/// The newest array's folder; empty: there has been none.
fs::path newest_folder(const ClusterBatch& batch) {
  fs::path newest;
  std::error_code error;
  for (fs::directory_iterator entry(cluster_folder(batch), error), end; !error && entry != end; entry.increment(error))
    if (entry->path().filename().string().starts_with("coppice-")) newest = std::max(newest, entry->path());
  return newest;
}

/// A path in double quotes, as sbatch reads it in a script: % is itself in `folder`, and begins a pattern in `name`.
std::string sbatch_quoted(const std::string& folder, const char* name) {
  std::string quoted = "\"";
  for (const char c : folder) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '%') quoted += '%';
    quoted += c;
  }
  return quoted + name + "\"";
}

std::string script_text(const ClusterBatch& batch, const Submission& submission) {
  std::string text = "#!/bin/sh\n";
  const auto option = [&text](const std::string& words) { text += "#SBATCH --" + words + "\n"; };
  option("nodes=1");
  option("ntasks=1");
  option("cpus-per-task=1");
  option("requeue");
  option("open-mode=append");
  option("time=" + std::to_string(submission.minutes));
  if (!chooses_memory(batch.sbatch_options)) option("mem-per-cpu=" + std::to_string(submission.memory_bytes / 1'000'000 + 1) + "M");
  option("output=" + sbatch_quoted(submission.folder.string(), "/%a.log"));
  text += "# Bakes a list of plants. A scheduler runs it once for each number from 0 to " + std::to_string(submission.tasks.size() - 1) +
          ". Slurm gives the number\n# itself; for others: sh THIS NUMBER\n";
  text += "tasks=" + shell_command({submission.folder.string()}) + "\n";
  text += "number=${1:-${SLURM_ARRAY_TASK_ID:?the number of a task}}\n";
  text += shell_command({batch.coppice.string(), "bake-all"}) + " \"$tasks/$number.json\" " +
          shell_command({"-o", batch.output_folder.string(), "--quiet"}) +
          " --threads \"${SLURM_CPUS_PER_TASK:-1}\" --journal \"$tasks/$number.jsonl\" " + shell_command(batch.task_options) + "\n";
  return text;
}

/// The lists first, then empty journals, so that a network file system knows of them when tasks have written there.
Result<void> write_submission(const ClusterBatch& batch, const Submission& submission) {
  for (std::size_t task = 0; task < submission.tasks.size(); ++task) {
    std::string list;
    for (const std::uint32_t plant : submission.tasks[task]) list += (list.empty() ? "[" : ",\n ") + batch.entries[plant];
    list += "]\n";
    COPPICE_CHECK(write_file_atomically(submission.file(task, ".json"), bytes_of(list)));
    COPPICE_CHECK(write_file_atomically(submission.file(task, ".jsonl"), {}));
  }
  return write_file_atomically(submission.folder / "run.sh", bytes_of(script_text(batch, submission)));
}

/// Tasks for some plants. Limits leave room for estimates that are wrong: one and a half times the memory, four times the time and ten
/// minutes, and twice of both for each attempt before.
Result<Submission> plan_submission(const ClusterBatch& batch, const std::vector<std::uint32_t>& plants, std::uint32_t attempt,
                                   std::uint32_t processors) {
  std::vector<PlantCost> costs;
  for (const std::uint32_t plant : plants) costs.push_back(batch.plants[plant].cost);
  TaskPlan plan;
  if (processors > 0) plan.slots = processors;
  Submission submission;
  submission.tasks = plan_tasks(costs, plan);
  std::uint64_t memory_bytes = 0, task_ms = 0;
  for (PlantGroup& task : submission.tasks) {
    std::uint64_t milliseconds = 0;
    for (std::uint32_t& index : task) {
      milliseconds += costs[index].milliseconds;
      memory_bytes = std::max(memory_bytes, costs[index].memory_bytes);
      index = plants[index];
    }
    task_ms = std::max(task_ms, milliseconds);
  }
  constexpr std::uint64_t kMinMemoryBytes = 512'000'000, kMaxMinutes = std::uint64_t{60} * 24 * 365;
  const std::uint64_t doubled = std::uint64_t{1} << (attempt - 1);
  submission.memory_bytes = doubled * std::max(kMinMemoryBytes, memory_bytes + memory_bytes / 2);
  submission.minutes = std::min(kMaxMinutes, doubled * (10 + 4 * (task_ms / 60'000)));
  COPPICE_CHECK(move_into(submission.folder, make_folder(batch)));
  COPPICE_CHECK(write_submission(batch, submission));
  return submission;
}

/// A run under way.
class ClusterRun {
 public:
  explicit ClusterRun(const ClusterBatch& batch) : batch_(batch), results_(batch.plants.size()), ended_(batch.plants.size(), false) {
    for (std::uint32_t plant = 0; plant < batch.plants.size(); ++plant) by_output_.emplace(batch.plants[plant].output.string(), plant);
  }

  Result<std::optional<std::vector<BatchResult>>> bake() {
    COPPICE_TRY(stays, wait_for_earlier_tasks());
    if (!stays) return std::optional<std::vector<BatchResult>>();
    COPPICE_CHECK(look_up());
    for (std::uint32_t attempt = 1; attempt <= kMaxAttempts && !is_cancelled_; ++attempt) {
      const std::vector<std::uint32_t> plants = missing();
      if (plants.empty()) break;
      for (const std::uint32_t plant : plants) results_[plant] = {};
      COPPICE_TRY(submission, plan_submission(batch_, plants, attempt, attempt == 1 ? slurm_processor_count() : 0));
      COPPICE_CHECK(submit(submission, attempt));
      COPPICE_CHECK(move_into(stays, wait_for(submission.folder)));
      if (!stays) return std::optional<std::vector<BatchResult>>();
      note_lost_tasks(submission);
    }
    return std::optional(std::move(results_));
  }

 private:
  [[nodiscard]] std::vector<std::uint32_t> missing() const {
    std::vector<std::uint32_t> plants;
    for (std::uint32_t plant = 0; plant < ended_.size(); ++plant)
      if (!ended_[plant]) plants.push_back(plant);
    return plants;
  }

  Result<bool> wait_for_earlier_tasks() {
    const fs::path folder = newest_folder(batch_);
    if (folder.empty()) return true;
    COPPICE_TRY(job, query_job(folder.filename().string()));
    if (!job.is_live()) return true;
    batch_.say("tasks of an earlier run are waited for first: " + folder.filename().string());
    COPPICE_TRY(stays, wait_for(folder));
    // They may have had other options. The cache tells what this batch can use of them.
    results_.assign(results_.size(), {});
    ended_.assign(ended_.size(), false);
    return stays;
  }

  Result<void> look_up() {
    BatchOptions options = batch_.options;
    options.look_up_only = options.other_batches = true;
    options.explain = false;
    COPPICE_TRY(found, bake_batch(batch_.plants, options, {}));
    for (std::uint32_t plant = 0; plant < found.size(); ++plant)
      if (found[plant].outcome == BatchOutcome::cached || !batch_.plants[plant].failure.empty()) end(plant, std::move(found[plant]));
    return {};
  }

  void end(std::uint32_t plant, BatchResult result) {
    ended_[plant] = !result.lost;
    results_[plant] = std::move(result);
  }

  Result<void> submit(const Submission& submission, std::uint32_t attempt) {
    const auto job = submit_array(submission.folder / "run.sh", submission.name(), submission.tasks.size(), batch_.sbatch_options);
    if (!job) {
      // The controller may have the tasks although sbatch did not hear it.
      const auto known = query_job(submission.name());
      if (known && known->is_live()) return {};
      std::error_code error;
      if (known || known.error().status == Status::unsupported) fs::remove_all(submission.folder, error);
      return job.error();
    }
    const std::string tasks = std::to_string(submission.tasks.size()) + (submission.tasks.size() == 1 ? " task" : " tasks");
    batch_.say(tasks + (attempt == 1 ? "" : " for what was lost, with twice the memory and time,") + " as job " + *job + "; scancel " +
               *job + " ends it");
    return {};
  }

  /// Back when no task of an array is in the queue any more, with what its journals say. returns  false: the user left
  Result<bool> wait_for(const fs::path& folder) {
    const auto start = Clock::now();
    auto answered = start;
    ClusterStatus status;
    while (true) {
      auto job = query_job(folder.filename().string());
      if (!job && (job.error().status == Status::unsupported || seconds_since(answered) > kMaxSilence_s)) return job.error();
      status.reason = job ? job->reason : job.error().message();
      if (job) answered = Clock::now();
      read_journals(folder);
      if (job && !job->is_live()) {
        job_ = *std::move(job);
        return true;
      }
      if (job) {
        status.running = job->running;
        status.pending = job->pending;
      }
      show(status);
      // Controllers are shared: long runs ask rarely.
      const double interval_s = std::clamp(seconds_since(start) / 30.0, 1.0, 15.0);
      for (const auto asked = Clock::now(); seconds_since(asked) < interval_s;) {
        if (batch_.is_stopped()) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
    }
  }

  void show(ClusterStatus& status) {
    double all = 0.0, done = 0.0;
    for (std::size_t plant = 0; plant < ended_.size(); ++plant) {
      const double cost = 1.0 + static_cast<double>(batch_.plants[plant].cost.milliseconds);
      all += cost;
      done += ended_[plant] ? cost : 0.0;
    }
    status.count = ended_.size();
    status.ended = static_cast<std::size_t>(std::ranges::count(ended_, true));
    status.fraction = all > 0.0 ? done / all : 1.0;
    batch_.progress(status);
  }

  /// Journals only grow, and the last entry of a plant counts.
  void read_journals(const fs::path& folder) {
    std::error_code error;
    for (fs::directory_iterator file(folder, error), last; !error && file != last; file.increment(error)) {
      if (file->path().extension() != ".jsonl") continue;
      const auto bytes = read_file(file->path());
      std::istringstream lines(bytes ? std::string(as_text(*bytes)) : std::string());
      for (std::string line; std::getline(lines, line);) {
        auto entry = journal_entry(line);
        const auto plant = entry ? by_output_.find(entry->output) : by_output_.end();
        if (plant != by_output_.end()) end(plant->second, std::move(entry->result));
      }
    }
  }

  /// Says which tasks left plants behind, and how they ended.
  void note_lost_tasks(const Submission& submission) {
    std::map<std::string, std::size_t> lost;  // tasks by their ends
    for (std::uint32_t task = 0; task < submission.tasks.size(); ++task) {
      if (std::ranges::all_of(submission.tasks[task], [this](std::uint32_t plant) { return ended_[plant]; })) continue;
      const auto ended = job_.ended.find(task);
      const std::string state = ended == job_.ended.end() ? "unknown" : ended->second;
      is_cancelled_ = is_cancelled_ || state == "CANCELLED";
      ++lost[state];
      for (const std::uint32_t plant : submission.tasks[task])
        if (!ended_[plant] && results_[plant].error.empty())
          results_[plant].error = "its task ended as " + state + "; " + submission.file(task, ".log").string() + " may say why";
    }
    for (const auto& [state, count] : lost)
      batch_.warn(std::to_string(count) + (count == 1 ? " task" : " tasks") + " did not finish: " + state + "; " +
                  submission.folder.string() + " has the logs");
  }

  const ClusterBatch& batch_;
  std::vector<BatchResult> results_;
  std::vector<bool> ended_;  ///< by plant; a lost one may be tried again
  std::map<std::string, std::uint32_t> by_output_;
  JobState job_;  ///< of the last array, at its end
  bool is_cancelled_ = false;
};

}  // namespace

Result<std::optional<std::vector<BatchResult>>> bake_on_cluster(const ClusterBatch& batch) {
  const fs::path lock_file = cluster_folder(batch) / "lock";
  COPPICE_CHECK(make_folder_of(lock_file));
  COPPICE_TRY(lock, FileLock::take(lock_file, LockKind::alone, "another bake-all waits for this batch"));
  return ClusterRun(batch).bake();
}

Result<std::string> write_tasks(const ClusterBatch& batch) {
  std::vector<std::uint32_t> plants;
  for (std::uint32_t plant = 0; plant < batch.plants.size(); ++plant)
    if (batch.plants[plant].failure.empty()) plants.push_back(plant);
  if (plants.empty()) return std::string();
  COPPICE_TRY(submission, plan_submission(batch, plants, 1, 0));
  return script_text(batch, submission);
}

}  // namespace coppice::bake
