#include "farm_follow.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <thread>
#include <tuple>
#include <utility>

#include "atomic_file.h"
#include "farm_tries.h"
#include "plant_record.h"
#include "slurm.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using TaskName = std::pair<std::uint32_t, std::uint32_t>;  ///< submission, task

/// A task that Slurm no longer has may have told its end in a file that is still on its way.
constexpr double kGraceSeconds = 4.0;
constexpr double kNoTraceSeconds = 60.0;
constexpr std::uint32_t kMostRefusals = 3;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// Controllers are shared: long runs ask rarely.
double asking_interval_s(double elapsed_s) {
  return std::clamp(elapsed_s / 30.0, 1.0, 20.0);
}

std::string last_line(const std::string& text) {
  std::size_t end = text.find_last_not_of(" \n\r\t");
  if (end == std::string::npos) return {};
  const std::size_t start = text.find_last_of('\n', end);
  return text.substr(start == std::string::npos ? 0 : start + 1, end - (start == std::string::npos ? 0 : start + 1) + 1);
}

class Follower {
 public:
  Follower(const FarmRun& run, const FollowOptions& options, std::vector<Submission> submissions)
      : run_(run), options_(options), submissions_(std::move(submissions)), plants_(run.plants.size()), current_(run.plants.size()) {
    for (const Submission& submission : submissions_) {
      take_plants(submission);
      bad_nodes_.insert(submission.excluded_nodes.begin(), submission.excluded_nodes.end());
    }
    for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
      by_output_.emplace(run.plants[plant].output.string(), plant);
      if (!run.plants[plant].failure.empty()) end_plant(plant, {.error = run.plants[plant].failure}, {});
    }
  }

  Result<FarmResults> follow() {
    read_own_journal();
    take_tries();
    was_over_ = ended_count_ == plants_.size();
    while (true) {
      if (is_time_to_read()) take_tries();
      if (ended_count_ == plants_.size()) {
        wait_for_ends();
        return results(FollowEnd::all_ended);
      }
      if (is_time_to_ask()) {
        COPPICE_CHECK(ask());
        continue;
      }
      if (options_.is_stopped && options_.is_stopped()) return results(FollowEnd::left);
      show();
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }

 private:
  /// Submissions to come, by attempt, memory, minutes and whether a bad node is the cause.
  using Again = std::map<std::tuple<std::uint32_t, std::uint64_t, std::uint32_t, bool>, Submission>;

  struct Plant {
    bool ended = false;
    BatchResult result;
    std::string try_name;
    std::optional<BatchResult> taken_away;
  };

  void take_plants(const Submission& submission) {
    for (std::uint32_t task = 0; task < submission.tasks.size(); ++task)
      for (const std::uint32_t plant : submission.tasks[task].plants) current_[plant] = {submission.number, task};
  }

  Submission& submission_of(std::uint32_t number) { return submissions_[number - 1]; }

  void end_plant(std::size_t plant, BatchResult result, const std::string& try_name) {
    if (plants_[plant].ended) return;
    plants_[plant] = {true, std::move(result), try_name, {}};
    ++ended_count_;
  }

  /// In the submitter's own journal, as no task tells it.
  Result<void> give_up(std::size_t plant, const std::string& why) {
    BatchResult result = plants_[plant].taken_away.value_or(BatchResult{});
    result.error = result.error.empty() ? why : result.error + "; " + why;
    COPPICE_TRY(journal, Journal::open(submitter_journal(run_.folder)));
    COPPICE_CHECK(journal.add({run_.plants[plant].input, run_.plants[plant].output, {}}, result));
    end_plant(plant, std::move(result), {});
    return {};
  }

  void read_own_journal() {
    std::ifstream file(submitter_journal(run_.folder));
    for (std::string line; std::getline(file, line);)
      if (auto entry = journal_entry(line); entry && by_output_.contains(entry->output))
        end_plant(by_output_.at(entry->output), std::move(entry->result), {});
  }

  void take_tries() {
    read_ = Clock::now();
    for (TriedPlant& tried : read_tries(run_.folder, tries_)) {
      const auto found = by_output_.find(tried.entry.output);
      if (found == by_output_.end()) continue;
      if (was_taken_away(tried.entry.result) || is_unseen(tried.entry.result, run_.plants[found->second].input))
        plants_[found->second].taken_away = std::move(tried.entry.result);
      else
        end_plant(found->second, std::move(tried.entry.result), tried.try_name);
    }
  }

  /// Tasks say that they end a moment after their last plant.
  void wait_for_ends() {
    constexpr double kMostSeconds = 2.0;
    const auto start = Clock::now();
    const auto ends = [this](const Plant& plant) {
      const auto found = tries_.find(plant.try_name);
      return found != tries_.end() && !found->second.exit_code;
    };
    while (std::ranges::any_of(plants_, ends) && seconds_since(start) < kMostSeconds) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      take_tries();
    }
  }

  [[nodiscard]] bool is_time_to_ask() const { return !asked_ || seconds_since(*asked_) >= asking_interval_s(seconds_since(start_)); }

  /// Tasks tell more often than Slurm is asked; a folder of many files on a network is not for every moment.
  [[nodiscard]] bool is_time_to_read() const { return !read_ || seconds_since(*read_) >= 0.25 * asking_interval_s(seconds_since(start_)); }

  Result<void> ask() {
    const std::function<bool()> waiting = [this] {
      show();
      return !options_.is_stopped || !options_.is_stopped();
    };
    asked_ = Clock::now();
    if (run_.submitter == Submitter::hand) return end_tasks({});
    Result<Queue> queue = ask_slurm(run_, submissions_, waiting);
    asked_ = Clock::now();
    if (!queue && options_.is_stopped && options_.is_stopped()) return {};
    if (!queue) {
      const bool is_new = std::ranges::all_of(submissions_, [](const Submission& submission) { return submission.job.empty(); });
      if (is_new || queue.error().status == Status::unsupported) return queue.error();
      note_ = queue.error().what;
      return {};
    }
    note_.clear();
    queue_ = *std::move(queue);
    for (const auto& [name, task] : queue_)
      if (!task.is_live) remembered_.insert_or_assign(name, task);
    take_tries();  // a task that Slurm no longer had has told its end before
    COPPICE_CHECK(submit_all());
    return end_tasks(queue_);
  }

  /// Submissions that the scheduler has although nobody wrote that down are taken over; the others are handed over.
  Result<void> submit_all() {
    for (Submission& submission : submissions_) {
      if (!submission.job.empty() || !submission.refused.empty()) continue;
      submission.job = job_by_traces(submission.number);
      if (submission.job.empty()) {
        COPPICE_CHECK(submit(submission));
      }
      if (submission.submitted_s == 0.0) submission.submitted_s = now_s();
      if (!submission.job.empty() && options_.submitted) options_.submitted(submission);
      COPPICE_CHECK(write_record(run_, submission));
    }
    return {};
  }

  [[nodiscard]] std::string job_by_traces(std::uint32_t number) const {
    for (const auto& [task, queued] : queue_)
      if (task.first == number && queued.is_live) return queued.job;
    for (const auto& [name, made] : tries_)
      if (made.submission == number) return made.array_job.empty() ? made.job : made.array_job;
    return {};
  }

  Result<void> submit(Submission& submission) {
    submission.submitted_s = now_s();
    auto job = submit_to_slurm(run_, submission, [this] {
      show();
      return true;  // cut short, nobody would know what it has done
    });
    if (job) {
      submission.job = *std::move(job);
      just_submitted_.insert(submission.number);
      return {};
    }
    if (job.error().status == Status::unsupported) return job.error();
    const bool is_first = std::ranges::all_of(submissions_, [](const Submission& other) { return other.job.empty(); });
    // It may have been taken: the queue will tell.
    const bool is_unknown = job.error().status == Status::io;
    if (is_first && (!is_unknown || ++refusals_[submission.number] >= kMostRefusals)) return job.error();
    if (is_unknown) {
      note_ = job.error().message();
      return {};
    }
    // A site may let nobody have more tasks at a time: there is room when some of ours have ended.
    if (has_live(queue_)) {
      note_ = job.error().message();
      return {};
    }
    if (++refusals_[submission.number] < kMostRefusals) return {};
    if (lower_limits(submission)) {
      refusals_[submission.number] = 0;
      return write_submission(run_, submission);
    }
    submission.refused = job.error().message();
    return {};
  }

  /// There may be no node of twice the memory, and no partition for twice the time. false: they are those of the first attempt
  bool lower_limits(Submission& submission) const {
    const bool has_memory = submission.attempt > 1 && submission.memory_bytes > submissions_.front().memory_bytes;
    if (has_memory) submission.memory_bytes /= 2;
    return lower_time(submission) || has_memory;
  }

  /// Of a later attempt, half of it, but no less than the first had. false: it has no more
  bool lower_time(Submission& submission) const {
    const std::uint32_t first = submissions_.front().minutes;
    if (submission.attempt == 1 || submission.minutes <= first) return false;
    submission.minutes = std::max(first, submission.minutes / 2);
    return true;
  }

  [[nodiscard]] std::vector<std::uint32_t> unfinished(const Submission& submission, std::uint32_t task) const {
    std::vector<std::uint32_t> plants;
    for (const std::uint32_t plant : submission.tasks[task].plants)
      if (!plants_[plant].ended && current_[plant] == TaskName(submission.number, task)) plants.push_back(plant);
    return plants;
  }

  /// Plants of tasks that are no more: tried again, or given up.
  Result<void> end_tasks(const Queue& queue) {
    running_ = waiting_ = 0;
    waits_for_.clear();
    std::vector<TaskName> lost;
    for (const Submission& submission : submissions_)
      for (std::uint32_t task = 0; task < submission.tasks.size(); ++task) {
        const TaskName name(submission.number, task);
        if (unfinished(submission, task).empty()) continue;
        if (submission.refused.empty() && is_under_way(submission, task, queue))
          gone_.erase(name);
        else if (!submission.refused.empty() || is_gone_for_good(name))
          lost.push_back(name);
      }
    just_submitted_.clear();
    COPPICE_CHECK(end_endless_waits(queue));
    most_running_ = std::max(most_running_, running_);
    warn_of_no_traces();
    return retry(lost);
  }

  bool is_under_way(const Submission& submission, std::uint32_t task, const Queue& queue) {
    if (run_.submitter == Submitter::hand) {
      bool has_begun = false, has_ended = false;
      for (const auto& [text, made] : tries_)
        if (made.submission == submission.number && made.task == task) has_begun = true, has_ended |= made.exit_code.has_value();
      ++(has_begun && !has_ended ? running_ : waiting_);
      return !has_ended;
    }
    // The answer is older than what was handed over after it; what is not handed over yet will be.
    if (submission.job.empty() || just_submitted_.contains(submission.number)) {
      ++waiting_;
      return true;
    }
    const auto found = queue.find({submission.number, task});
    if (found == queue.end() || !found->second.is_live) return false;
    ++(found->second.runs ? running_ : waiting_);
    if (!found->second.runs) waits_for_ = found->second.reason;
    return true;
  }

  /// Tasks that ask for more time than is allowed: those that ask for more than at first get less, of others a person hears.
  Result<void> end_endless_waits(const Queue& queue) {
    std::map<std::uint32_t, std::vector<FarmTask>> endless;  // by submission
    for (const Submission& submission : submissions_)
      for (std::uint32_t task = 0; task < submission.tasks.size() && !endless_.contains(submission.number); ++task) {
        const auto found = queue.find({submission.number, task});
        if (found == queue.end() || !has_too_much_time(found->second)) continue;
        if (auto plants = unfinished(submission, task); !plants.empty()) endless[submission.number].push_back({std::move(plants)});
      }
    for (auto& [number, tasks] : endless) {
      endless_.insert(number);
      const Submission& asked = submission_of(number);
      Submission next;
      next.attempt = asked.attempt;
      next.memory_bytes = asked.memory_bytes;
      next.minutes = asked.minutes;
      next.because = asked.because;
      next.tasks = std::move(tasks);
      if (lower_time(next)) {
        cancel_waiting(asked.job);
        COPPICE_CHECK(add_submission(std::move(next)));
      } else if (options_.say) {
        options_.say("job " + asked.job + " waits for ever: nobody may have the " + std::to_string(asked.minutes) +
                     " minutes that its tasks ask for; scancel " + asked.job +
                     " ends it, and options of sbatch after -- choose another partition, or a time");
      }
    }
    return {};
  }

  bool is_gone_for_good(const TaskName& name) {
    const auto [found, is_new] = gone_.try_emplace(name, Clock::now());
    if (is_new) refresh_tries(run_.folder);
    return !is_new && seconds_since(found->second) >= kGraceSeconds;
  }

  [[nodiscard]] const TaskTry* last_try(const TaskName& name) const {
    const TaskTry* last = nullptr;
    for (const auto& [text, made] : tries_)
      if (TaskName(made.submission, made.task) == name && (last == nullptr || made.started_s > last->started_s)) last = &made;
    return last;
  }

  /// Whether a plant could not be read where this machine can: the node does not see its folder, or not well. A file that it refers to is
  /// its own fault.
  static bool is_unseen(const BatchResult& result, const fs::path& input) {
    return result.outcome == BatchOutcome::failed && result.error.find("cannot read: " + input.string() + ": ") != std::string::npos &&
           ::access(input.c_str(), R_OK) == 0;
  }

  [[nodiscard]] bool has_unseen(const TaskName& name) const {
    return std::ranges::any_of(unfinished(submissions_[name.first - 1], name.second), [this](std::uint32_t plant) {
      return plants_[plant].taken_away && is_unseen(*plants_[plant].taken_away, run_.plants[plant].input);
    });
  }

  /// Why a task is no more.
  struct Loss {
    std::string why;
    std::string bad_node;      ///< where no task can do anything: it does not see OUT, or has no program; empty
    bool is_hopeless = false;  ///< it is not to be tried again
  };

  /// "its task was lost on node2 (TIMEOUT)"
  [[nodiscard]] Loss loss_of(const TaskName& name) const {
    const Submission& submission = submissions_[name.first - 1];
    if (!submission.refused.empty()) return {submission.refused + (submission.because.empty() ? "" : "; " + submission.because), {}, true};
    const bool by_hand = run_.submitter == Submitter::hand;
    const TaskTry* const made = last_try(name);
    if (made != nullptr && made->exit_code) {
      constexpr int kUsage = 2, kNotExecutable = 126, kNotFound = 127;
      const int code = *made->exit_code;
      const std::string said = last_line(tail_of(made->log));
      const bool lacks_program = code == kNotExecutable || code == kNotFound;
      Loss loss{"its task ended on " + made->node + " with exit code " + std::to_string(code) + (said.empty() ? "" : ": " + said) +
                    (lacks_program ? "; --coppice says where nodes have the program" : ""),
                {}};
      if (lacks_program || has_unseen(name)) loss.bad_node = made->node;
      loss.is_hopeless = by_hand || code == kUsage;
      return loss;
    }
    const auto queued = remembered_.find(name);
    const std::string state = queued == remembered_.end() ? "" : queued->second.state, shown = state.empty() ? "" : " (" + state + ")";
    if (state == "CANCELLED") return {"its task was cancelled", {}, true};
    if (made != nullptr) return {"its task was lost on " + made->node + shown, {}, by_hand};
    const std::string node = queued == remembered_.end() ? "" : queued->second.node;
    if (node.empty() || (state != "FAILED" && state != "COMPLETED"))
      return {"its task left no trace" + shown + ": OUT must be in a folder that all nodes share; Slurm's word is in " +
                  run_.folder.string() + "/slurm-" + submission.job + "_" + std::to_string(name.second) + ".out",
              {},
              by_hand};
    return {"its task left no trace on " + node + shown + ", which must see " + run_.folder.string(), node, by_hand};
  }

  void leave_out(const std::string& node, const std::string& why) {
    if (!bad_nodes_.insert(node).second || !options_.say) return;
    options_.say(node + " gets no more tasks: " + why);
  }

  /// Whether a bad node is the cause, and one that tasks can be kept from: options of sbatch's command line go before ours.
  static bool is_spared(const Submission& submission, const Loss& loss) {
    return !loss.bad_node.empty() && std::ranges::find(submission.excluded_nodes, loss.bad_node) == submission.excluded_nodes.end();
  }

  /// A bad node costs no attempt.
  void try_again(const Submission& submission, const Loss& loss, const std::vector<std::uint32_t>& plants, Again& again) const {
    const bool spared = is_spared(submission, loss);
    Submission& next = again[{submission.attempt, submission.memory_bytes, submission.minutes, spared}];
    next.attempt = submission.attempt + (spared ? 0 : 1);
    next.memory_bytes = submission.memory_bytes * (spared ? 1 : 2);
    next.minutes = submission.minutes * (spared ? 1 : 2);
    next.because = loss.why;
    add_tasks(next, plants);
  }

  Result<void> retry(const std::vector<TaskName>& lost) {
    Again again;
    for (const TaskName& name : lost) {
      const Submission& submission = submission_of(name.first);
      const std::vector<std::uint32_t> plants = unfinished(submission, name.second);
      const Loss loss = loss_of(name);
      if (!loss.bad_node.empty()) leave_out(loss.bad_node, loss.why);
      const bool is_last = submission.attempt >= run_.most_attempts && !is_spared(submission, loss);
      if (loss.is_hopeless || is_last) {
        const std::string attempts = submission.attempt > 1 ? ", after " + std::to_string(submission.attempt) + " attempts" : "";
        for (const std::uint32_t plant : plants) {
          COPPICE_CHECK(give_up(plant, loss.why + attempts));
        }
        continue;
      }
      if (options_.say && loss.bad_node.empty())
        options_.say(std::to_string(plants.size()) + (plants.size() == 1 ? " plant is" : " plants are") + " tried again: " + loss.why);
      try_again(submission, loss, plants, again);
    }
    const std::size_t most = PlanOptions{}.most_tasks_of_array;
    for (const auto& [limits, submission] : again)
      for (std::size_t first = 0; first < submission.tasks.size(); first += most) {
        Submission part = submission;
        const auto begin = submission.tasks.begin() + static_cast<std::ptrdiff_t>(first);
        part.tasks.assign(begin, begin + static_cast<std::ptrdiff_t>(std::min(most, submission.tasks.size() - first)));
        COPPICE_CHECK(add_submission(std::move(part)));
      }
    return {};
  }

  Result<void> add_submission(Submission submission) {
    submission.number = static_cast<std::uint32_t>(submissions_.size()) + 1;
    submission.excluded_nodes.assign(bad_nodes_.begin(), bad_nodes_.end());
    COPPICE_CHECK(write_submission(run_, submission));
    take_plants(submission);
    submissions_.push_back(std::move(submission));
    asked_.reset();  // to hand it over now
    return {};
  }

  /// At last every plant is alone: one that takes its task with it shall not take others.
  void add_tasks(Submission& submission, const std::vector<std::uint32_t>& plants) const {
    if (submission.attempt < run_.most_attempts)
      submission.tasks.push_back({plants});
    else
      for (const std::uint32_t plant : plants) submission.tasks.push_back({{plant}});
  }

  void warn_of_no_traces() {
    if (running_ == 0 || !tries_.empty()) {
      first_running_.reset();
      return;
    }
    if (!first_running_) first_running_ = Clock::now();
    if (warned_ || seconds_since(*first_running_) < kNoTraceSeconds) return;
    warned_ = true;
    refresh_tries(run_.folder);
    if (options_.say)
      options_.say("tasks run, and none has written to " + run_.folder.string() + " yet: OUT must be in a folder that all nodes share");
  }

  void show() const {
    if (!options_.progress) return;
    double all_ms = 0.0, ended_ms = 0.0;
    for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
      const auto ms = static_cast<double>(run_.plants[plant].cost.milliseconds);
      all_ms += ms;
      if (plants_[plant].ended) ended_ms += ms;
    }
    options_.progress({ended_count_, plants_.size(), all_ms > 0.0 ? ended_ms / all_ms : 0.0, running_, waiting_, waits_for_, note_});
  }

  /// Tries that began with a plant, up to the one that ended it.
  [[nodiscard]] std::uint32_t attempts_of(std::uint32_t plant, const TaskTry* last) const {
    std::uint32_t attempts = 0;
    for (const auto& [name, made] : tries_) {
      if (made.submission < 1 || made.submission > submissions_.size()) continue;
      const std::vector<FarmTask>& tasks = submissions_[made.submission - 1].tasks;
      const bool has_plant = made.task < tasks.size() && std::ranges::find(tasks[made.task].plants, plant) != tasks[made.task].plants.end();
      if (has_plant && (last == nullptr || made.started_s <= last->started_s)) ++attempts;
    }
    return attempts;
  }

  /// Of the try that ended a plant, else of the last one that had it.
  [[nodiscard]] std::string log_tail_of(std::uint32_t plant, const TaskTry* last) const {
    if (last == nullptr) last = last_try(current_[plant]);
    return last == nullptr ? std::string() : tail_of(last->log);
  }

  [[nodiscard]] std::vector<FarmTry> tries() const {
    std::vector<FarmTry> tries;
    const double submitted_s = submissions_.empty() ? 0.0 : submissions_.front().submitted_s;
    for (const auto& [name, made] : tries_)
      tries.push_back({made.submission, made.task, made.node, made.started_s - submitted_s,
                       made.ended_s > made.started_s ? made.ended_s - made.started_s : 0.0, made.exit_code});
    std::ranges::stable_sort(tries, {}, &FarmTry::start_s);
    return tries;
  }

  /// When the run ended: now, or where it ended while nobody followed it, when its last task did.
  [[nodiscard]] double end_s() const {
    double last_s = 0.0;
    for (const auto& [name, made] : tries_) last_s = std::max(last_s, made.ended_s);
    return was_over_ && last_s > submissions_.front().submitted_s ? last_s : now_s();
  }

  [[nodiscard]] FarmResults results(FollowEnd end) const {
    FarmResults results;
    results.end = end;
    for (std::uint32_t plant = 0; plant < plants_.size(); ++plant) {
      FarmPlantEnd ended;
      ended.result = plants_[plant].result;
      const auto found = tries_.find(plants_[plant].try_name);
      const TaskTry* const last = found == tries_.end() ? nullptr : &found->second;
      ended.attempts = attempts_of(plant, last);
      if (last != nullptr && last->submission >= 1 && last->submission <= submissions_.size()) {
        ended.node = last->node;
        ended.queue_seconds = std::max(0.0, last->started_s - submissions_[last->submission - 1].submitted_s);
      }
      if (ended.result.outcome == BatchOutcome::failed) ended.log_tail = log_tail_of(plant, last);
      results.plants.push_back(std::move(ended));
    }
    for (const Submission& submission : submissions_) {
      results.task_count += submission.tasks.size();
      if (submission.attempt > 1) results.retried_task_count += submission.tasks.size();
    }
    results.most_running = most_running_;
    if (!submissions_.empty() && submissions_.front().submitted_s > 0.0) results.seconds = end_s() - submissions_.front().submitted_s;
    results.tries = tries();
    return results;
  }

  const FarmRun& run_;
  const FollowOptions& options_;
  std::vector<Submission> submissions_;
  std::vector<Plant> plants_;
  std::vector<TaskName> current_;  ///< the last task that got each plant
  std::map<std::string, std::size_t> by_output_;
  std::size_t ended_count_ = 0, running_ = 0, waiting_ = 0, most_running_ = 0;
  Tries tries_;
  Queue queue_, remembered_;                    ///< what Slurm says now, and said last of tasks that had ended: it forgets them
  std::map<TaskName, Clock::time_point> gone_;  ///< since when Slurm does not have them
  std::set<std::string> bad_nodes_;
  std::set<std::uint32_t> just_submitted_, endless_;  ///< submissions; those whose tasks would wait for ever
  std::map<std::uint32_t, std::uint32_t> refusals_;
  std::optional<Clock::time_point> asked_, read_, first_running_;
  bool warned_ = false, was_over_ = false;
  std::string note_, waits_for_;
  const Clock::time_point start_ = Clock::now();
};

}  // namespace

bool was_taken_away(const BatchResult& result) {
  if (result.outcome != BatchOutcome::failed) return false;
  constexpr std::array<std::string_view, 4> kStarts{"ended by a signal: Killed", "ended by a signal: Terminated",
                                                    "no process: ", "no pipe: "};
  return result.error == "out of memory" ||
         std::ranges::any_of(kStarts, [&](std::string_view start) { return result.error.starts_with(start); });
}

Result<FarmResults> follow_run(const FarmRun& run, const FollowOptions& options) {
  COPPICE_TRY(lock, RunLock::take(run.folder));
  COPPICE_TRY(submissions, read_submissions(run));
  return Follower(run, options, std::move(submissions)).follow();
}

}  // namespace coppice::bake
