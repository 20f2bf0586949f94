#pragma once

// The caches that a batch uses, as the process that starts the jobs sees them.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "bake_batch.h"
#include "cached_bake.h"
#include "file_lock.h"
#include "http_cache.h"
#include "result.h"
#include "why_baked.h"

namespace coppice::bake {

/// The caches of a batch while it runs, and what is known of them.
class BatchCaches {
 public:
  /// errors  io: `options.cache` cannot be made, or another process is using it. The report names what is wrong with a shared cache.
  static Result<BatchCaches> open(const BatchOptions& options);

  [[nodiscard]] const JobCache& jobs() const { return jobs_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return jobs_.folder; }
  /// Whether a server is asked before plants are baked.
  [[nodiscard]] bool has_server() const { return server_ != nullptr; }
  /// Takes note of a plant's end. Jobs that start after some failures in a row of the folder, or of the server, leave that one alone.
  void ended(const BatchResult& result);
  /// Takes note of a look-up that found nothing.
  void missed(const BatchResult& result);
  [[nodiscard]] CacheReport report() const;

 private:
  Result<void> open_folder(const BatchOptions& options);

  /// Takes note of whether the caches were of use to a plant.
  void note_use(const BatchResult& result);

  JobCache jobs_;
  std::optional<FileLock> lock_;
  std::unique_ptr<HttpCache> server_;             // where jobs_ points to
  std::unique_ptr<std::vector<KnownKey>> known_;  // likewise
  CacheReport report_;
};

}  // namespace coppice::bake
