#include "cluster_batch.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iomanip>
#include <map>
#include <numeric>
#include <random>
#include <sstream>
#include <system_error>
#include <thread>
#include <utility>

#include "atomic_file.h"
#include "cache_location.h"
#include "plant_cost.h"
#include "plant_record.h"
#include "slurm.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::uint32_t kMaxAttempts = 3;
constexpr auto kMaxSilence = 10min;  // while Slurm's controller does not answer

fs::path cluster_folder(const ClusterBatch& batch) {
  return batch.output_folder / kOwnClusterRuns;
}

/// An array of tasks.
struct Submission {
  fs::path folder;  ///< its name is the job's
  std::vector<PlantGroup> tasks;
  std::uint64_t memory_bytes = 0;  ///< for each processor
  std::uint64_t minutes = 0;

  [[nodiscard]] fs::path file(std::size_t task, const char* extension) const { return folder / (std::to_string(task) + extension); }
};

Result<fs::path> make_run_folder(const ClusterBatch& batch) {
  const std::time_t now = std::time(nullptr);
  std::tm calendar{};
  static_cast<void>(::gmtime_r(&now, &calendar));
  std::ostringstream name;
  name << "coppice-" << std::put_time(&calendar, "%Y%m%d-%H%M%S-") << std::random_device()();
  fs::path folder = cluster_folder(batch) / name.str();
  COPPICE_TRY(place, find_place(folder / ".", LastLink::stays, MissingFolders::are_made));
  std::error_code error;
  fs::permissions("/proc/self/fd/" + std::to_string(place.folder.number()) + "/.", fs::perms::group_write | fs::perms::others_write,
                  fs::perm_options::remove, error);
  return folder;
}

/// Slurm would follow a link of anybody's to its log. So the script opens that itself, in a folder that nobody has put in the place of
/// ours.
std::string script_text(const ClusterBatch& batch, const Submission& submission) {
  const std::string folder = submission.folder.string();
  std::ostringstream text;
  text << "#!/bin/sh\n#SBATCH --nodes=1 --ntasks=1 --cpus-per-task=1 --requeue --output=/dev/null\n#SBATCH --time=" << submission.minutes
       << "\n";
  if (!chooses_memory(batch.sbatch_options)) text << "#SBATCH --mem-per-cpu=" << submission.memory_bytes / 1'000'000 + 1 << "M\n";
  text << "# Bakes a list of plants. A scheduler runs it once for each number from 0 to " << submission.tasks.size() - 1
       << ". Slurm gives the number\n# itself; for others: sh THIS NUMBER\ntasks=" << shell_command({folder})
       << "\nnumber=${1:-${SLURM_ARRAY_TASK_ID:?the number of a task}}\n"
       << "# Only in a folder that is ours, and where nobody else writes.\ncd \"$tasks\" && [ -O . ] && ls -ld . | grep -q '^d....-..-' "
          "&& exec >>\"$number.log\" 2>&1 && cd \"$OLDPWD\" || exit 1\n"
       << shell_command({batch.coppice.string(), "bake-all"}) << " \"$tasks/$number.json\" "
       << shell_command({"-o", batch.output_folder.string(), "--quiet"})
       << " --threads \"${SLURM_CPUS_PER_TASK:-1}\" --journal \"$tasks/$number.jsonl\" " << shell_command(batch.task_options) << "\n";
  return text.str();
}

/// Tasks for some plants. Limits leave room for estimates that are wrong: one and a half times the memory, four times the time and ten
/// minutes, and twice of both for each attempt before.
Result<Submission> plan_submission(const ClusterBatch& batch, const std::vector<std::uint32_t>& plants, std::uint32_t attempt,
                                   std::uint32_t processors) {
  std::vector<PlantCost> costs;
  for (const std::uint32_t plant : plants) costs.push_back(batch.plants[plant].cost);
  TaskPlan plan;
  if (processors > 0) plan.slots = std::max(1u, processors / processors_of_task(batch.sbatch_options));
  Submission submission;
  submission.tasks = plan_tasks(costs, plan);
  std::uint64_t task_ms = 0;
  for (PlantGroup& task : submission.tasks) {
    const auto add = [&costs](std::uint64_t sum, std::uint32_t index) { return sum + costs[index].milliseconds; };
    task_ms = std::max(task_ms, std::accumulate(task.begin(), task.end(), std::uint64_t{0}, add));
    for (std::uint32_t& index : task) index = plants[index];
  }
  constexpr std::uint64_t kMinMemoryBytes = 512'000'000, kMaxMinutes = std::uint64_t{60} * 24 * 365;
  const std::uint64_t doubled = std::uint64_t{1} << (attempt - 1);
  const std::uint64_t memory_bytes = std::ranges::max(costs, {}, &PlantCost::memory_bytes).memory_bytes;
  submission.memory_bytes = doubled * std::max(kMinMemoryBytes, memory_bytes + memory_bytes / 2);
  submission.minutes = std::min(kMaxMinutes, doubled * (10 + 4 * (task_ms / 60'000)));
  COPPICE_CHECK(move_into(submission.folder, make_run_folder(batch)));
  // The lists first, then empty journals, so that a network file system knows of them when tasks have written there.
  for (std::size_t task = 0; task < submission.tasks.size(); ++task) {
    std::string list;
    for (const std::uint32_t plant : submission.tasks[task]) list += (list.empty() ? "[" : ",\n ") + batch.entries[plant];
    COPPICE_CHECK(write_file_atomically(submission.file(task, ".json"), bytes_of(list + "]\n")));
    COPPICE_CHECK(write_file_atomically(submission.file(task, ".jsonl"), {}));
  }
  COPPICE_CHECK(write_file_atomically(submission.folder / "run.sh", bytes_of(script_text(batch, submission))));
  return submission;
}

/// Whether there is nothing more to do for a plant. A lost one may be tried again.
bool has_ended(const BatchResult& result) {
  return result.outcome != BatchOutcome::failed || (!result.error.empty() && !result.lost);
}

/// A run under way.
class ClusterRun {
 public:
  explicit ClusterRun(const ClusterBatch& batch) : batch_(batch), costs_(costs_of(batch.plants)), results_(batch.plants.size()) {
    for (std::uint32_t plant = 0; plant < batch.plants.size(); ++plant) by_output_.emplace(batch.plants[plant].output.string(), plant);
  }

  Result<std::optional<std::vector<BatchResult>>> bake() {
    COPPICE_CHECK(wait_for_earlier_tasks());
    COPPICE_CHECK(look_up());
    std::vector<std::uint32_t> plants = missing();
    for (std::uint32_t attempt = 1; attempt <= kMaxAttempts && !plants.empty() && !has_left_ && !is_cancelled_; ++attempt) {
      for (const std::uint32_t plant : plants) results_[plant] = {};
      COPPICE_TRY(submission, plan_submission(batch_, plants, attempt, attempt == 1 ? slurm_processor_count() : 0));
      COPPICE_CHECK(submit(submission, attempt));
      COPPICE_CHECK(wait_for(submission.folder));
      if (!has_left_) note_lost_tasks(submission);
      plants = missing();
    }
    return has_left_ ? std::nullopt : std::optional(std::move(results_));
  }

 private:
  [[nodiscard]] std::vector<std::uint32_t> missing() const {
    std::vector<std::uint32_t> plants;
    for (std::uint32_t plant = 0; plant < results_.size(); ++plant)
      if (!has_ended(results_[plant])) plants.push_back(plant);
    return plants;
  }

  Result<void> wait_for_earlier_tasks() {
    fs::path folder;  // the newest array's
    std::error_code error;
    for (fs::directory_iterator entry(cluster_folder(batch_), error), end; !error && entry != end; entry.increment(error))
      if (entry->path().filename().string().starts_with("coppice-")) folder = std::max(folder, entry->path());
    if (folder.empty()) return {};
    COPPICE_TRY(job, query_job(folder.filename().string()));
    if (!job.is_live()) return {};
    batch_.say("tasks of an earlier run are waited for first: " + folder.filename().string());
    COPPICE_CHECK(wait_for(folder));
    // They may have had other options. The cache tells what this batch can use of them.
    results_.assign(results_.size(), {});
    return {};
  }

  Result<void> look_up() {
    if (has_left_) return {};
    COPPICE_TRY(found, bake_batch(batch_.plants, batch_.options, {}));
    for (std::size_t plant = 0; plant < found.size(); ++plant)
      if (found[plant].outcome == BatchOutcome::cached || !batch_.plants[plant].failure.empty()) results_[plant] = std::move(found[plant]);
    return {};
  }

  Result<void> submit(const Submission& submission, std::uint32_t attempt) {
    const std::string name = submission.folder.filename().string();
    const auto job = submit_array(script_text(batch_, submission), name, submission.tasks.size(), batch_.sbatch_options);
    if (!job) {
      // The controller may have the tasks although sbatch did not hear it.
      const auto known = query_job(name);
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

  /// Back when no task of an array is in the queue any more, with what its journals say, or when the user has left.
  Result<void> wait_for(const fs::path& folder) {
    const auto start = Clock::now();
    auto answered = start;
    job_ = {};
    while (true) {
      auto job = query_job(folder.filename().string());
      if (!job && (job.error().status == Status::unsupported || Clock::now() - answered > kMaxSilence)) return job.error();
      read_journals(folder);
      const std::string trouble = job ? "" : job.error().message();
      if (job) {
        answered = Clock::now();
        job_ = *std::move(job);
        if (!job_.is_live()) return {};
      }
      show(trouble.empty() ? job_.reason : trouble);
      // Controllers are shared: long runs ask rarely.
      const auto next = Clock::now() + std::clamp<Clock::duration>((Clock::now() - start) / 30, 1s, 15s);
      while (Clock::now() < next) {
        has_left_ = batch_.is_stopped();
        if (has_left_) return {};
        std::this_thread::sleep_for(100ms);
      }
    }
  }

  /// reason: why tasks wait, or why Slurm does not say how they are
  void show(const std::string& reason) {
    std::vector<double> done;
    for (const BatchResult& result : results_) done.push_back(has_ended(result) ? 1.0 : 0.0);
    BatchStatus status{static_cast<std::size_t>(std::ranges::count(done, 1.0)), done.size(), done_fraction(costs_, done), {}};
    status.running =
        std::to_string(job_.running) + (job_.running == 1 ? " task runs, " : " tasks run, ") + std::to_string(job_.pending) + " wait";
    if (job_.running == 0 && !reason.empty()) status.running += ": " + reason;
    batch_.progress(status);
  }

  /// Journals only grow, and the last entry of a plant counts.
  void read_journals(const fs::path& folder) {
    std::error_code error;
    for (fs::directory_iterator file(folder, error), last; !error && file != last; file.increment(error)) {
      if (file->path().extension() != ".jsonl") continue;
      const auto bytes = read_kept_file(file->path(), FileOwner::user);
      std::istringstream lines(bytes ? std::string(as_text(*bytes)) : std::string());
      for (std::string line; std::getline(lines, line);) {
        auto entry = journal_entry(line);
        const auto plant = entry ? by_output_.find(entry->output) : by_output_.end();
        if (plant != by_output_.end()) results_[plant->second] = std::move(entry->result);
      }
    }
  }

  /// Says which tasks left plants behind, and how they ended.
  void note_lost_tasks(const Submission& submission) {
    std::map<std::string, std::size_t> lost;  // tasks by their ends
    for (std::uint32_t task = 0; task < submission.tasks.size(); ++task) {
      if (std::ranges::all_of(submission.tasks[task], [this](std::uint32_t plant) { return has_ended(results_[plant]); })) continue;
      const std::string state = job_.ended.contains(task) ? job_.ended.at(task) : "unknown";
      is_cancelled_ = is_cancelled_ || state == "CANCELLED";
      ++lost[state];
      for (const std::uint32_t plant : submission.tasks[task])
        if (results_[plant].outcome == BatchOutcome::failed && results_[plant].error.empty()) {
          results_[plant].error = "its task ended as " + state + "; " + submission.file(task, ".log").string() + " may say why";
          results_[plant].lost = true;
        }
    }
    for (const auto& [state, count] : lost)
      batch_.warn(std::to_string(count) + (count == 1 ? " task" : " tasks") + " did not finish: " + state + "; " +
                  submission.folder.string() + " has the logs");
  }

  const ClusterBatch& batch_;
  std::vector<PlantCost> costs_;
  std::vector<BatchResult> results_;
  std::map<std::string, std::uint32_t> by_output_;
  JobState job_;           ///< the last array's, as Slurm last said
  bool has_left_ = false;  ///< the user
  bool is_cancelled_ = false;
};

}  // namespace

Result<std::optional<std::vector<BatchResult>>> bake_on_cluster(const ClusterBatch& batch) {
  const fs::path path = cluster_folder(batch) / "lock";
  COPPICE_CHECK(make_folder_of(path));
  COPPICE_TRY(lock, lock_file(path, LockKind::alone, "another bake-all waits for this batch"));
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
