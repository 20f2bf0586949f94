#pragma once

// Keeps pipelines behind decoding in any pool of threads. It stands between the library and the jobs hook and counts the decode jobs that
// no thread has begun. While there are some, jobs that build pipelines are held back: those that come are not submitted, and those that the
// pool begins return without work. The decode job that begins last submits them.

#include <cstdint>
#include <mutex>

#include "coppice/coppice.h"

namespace coppice {

/// Returns a job for a jobs hook.
coppice_job make_job(coppice_job_kind kind, coppice_priority priority, void (*function)(void* argument), void* argument);

class JobOrder {
 public:
  /// However much decoding waits, a pipeline begins after this time.
  static constexpr std::uint64_t kMaxHeldNs = 500'000'000;

  /// hook: complete. allocator: provides a few bytes a job; without memory the job goes to the hook as it is
  JobOrder(const coppice_jobs& hook, const coppice_allocator& allocator, std::uint64_t (*clock_ns)());
  /// Before: every job has run.
  ~JobOrder() = default;
  JobOrder(const JobOrder&) = delete;
  JobOrder& operator=(const JobOrder&) = delete;

  /// The hook with this order. It must not outlive this object.
  [[nodiscard]] coppice_jobs hook();
  /// Submits a pipeline that has been held back for too long. Call it once a frame.
  void release_overdue();

 private:
  struct Task {
    JobOrder* order = nullptr;
    coppice_job job{};
    std::uint64_t number = 0;  ///< in order of submission
    Task* next = nullptr;      ///< among those held
  };
  void submit(const coppice_job& job);
  void submit(Task* task);
  static void run(void* task);
  /// True if a pipeline may begin now. before: mutex_ is held, here and below
  [[nodiscard]] bool may_begin() const;
  void hold(Task* task);
  Task* take_held();

  coppice_jobs hook_{};
  coppice_allocator allocator_{};
  std::uint64_t (*clock_ns_)() = nullptr;
  std::mutex mutex_;                 ///< guards the fields below
  std::uint32_t waiting_count_ = 0;  ///< decode jobs that have been submitted and not begun
  std::uint64_t last_begin_ns_ = 0;  ///< time at which the last pipeline began
  std::uint64_t submitted_count_ = 0;
  Task* held_ = nullptr;  ///< in order of submission
};

}  // namespace coppice
