#pragma once

// The caches that a batch uses, as the process that starts the jobs sees them.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "bake_batch.h"
#include "cache_courier.h"
#include "cached_bake.h"
#include "result.h"
#include "why_baked.h"

namespace coppice::bake {

/// Keeps other batches out of a cache for as long as it lives, or the process does; one that shares it, only those that do not. Processes
/// that are forked off do not hold it.
class CacheLock {
 public:
  /// errors  io: another process has it
  static Result<CacheLock> take(const std::filesystem::path& cache, bool shares);
  CacheLock(CacheLock&& other) noexcept;
  CacheLock& operator=(CacheLock&&) = delete;
  ~CacheLock();

 private:
  explicit CacheLock(int file) : file_(file) {}
  int file_;
};

/// The caches of a batch while it runs, and what is known of them.
class BatchCaches {
 public:
  /// errors  io: `options.cache` cannot be made, or another process is using it. What is wrong with a shared one is in the report.
  static Result<BatchCaches> open(const BatchOptions& options, std::size_t job_count);

  [[nodiscard]] const JobCache& jobs() const { return jobs_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return jobs_.folder; }
  /// What became of a plant. A folder that takes nothing is no longer tried by jobs that start after that.
  void ended(const BatchResult& result);
  /// A plant was looked for, not found, and left to others.
  void missed() { ++folder_report_.lacking; }
  /// Lets what is left be sent.
  CacheReport finish();

 private:
  Result<void> open_folder(const BatchOptions& options);

  JobCache jobs_;
  std::optional<CacheLock> lock_;
  std::optional<CacheCourier> courier_;
  std::unique_ptr<std::vector<KnownKey>> known_;  // where jobs_ points to
  std::size_t failures_in_a_row_ = 0;
  CacheReport folder_report_;
};

}  // namespace coppice::bake
