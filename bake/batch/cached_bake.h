#pragma once

// The caches of a batch: as a job sees them, which finds a plant there or bakes it and keeps it, and as the process sees them that starts
// jobs.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "bake_batch.h"
#include "http_cache.h"
#include "key_parts.h"
#include "result.h"
#include "temporary_file.h"

namespace coppice::bake {

/// The caches in which a job finds and keeps results.
struct JobCache {
  std::filesystem::path folder = {};     ///< empty: none
  std::filesystem::path read_only = {};  ///< another folder, asked for what `folder` lacks; empty: none
  HttpCache* server = nullptr;           ///< load_one asks it, bake_one sends to it; null: none
  CacheMode server_mode = CacheMode::read_write;
  FailureCount folder_failures = {};
  bool needed = true;  ///< a result that the folder does not take is a failure of the plant
  /// The folders' entries as they were before the batch: what explanations compare with; null: nobody wants any
  const std::vector<KnownKey>* known = nullptr;
};

/// As bake_cached, with all caches of a batch.
BatchResult bake_one(const BatchPlant& plant, const JobCache& cache, const StageProgress& progress);

/// Finds a plant in the caches, the server's too. A plant that none of them has fails. A damaged entry of `cache.folder` stays for whoever
/// bakes the plant.
BatchResult load_one(const BatchPlant& plant, const JobCache& cache);

/// The caches of a batch while it runs, and what is known of them.
class BatchCaches {
 public:
  /// errors  io: `options.cache` cannot be made, or another process is using it. The report names what is wrong with a shared cache.
  static Result<BatchCaches> open(const std::vector<BatchPlant>& plants, const BatchOptions& options);

  [[nodiscard]] const JobCache& jobs() const { return jobs_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return jobs_.folder; }
  /// Takes note of a plant's end. Jobs that start after some failures in a row of the folder write no more to it; after
  /// some of the server they leave it alone.
  void ended(const BatchResult& result);
  /// Takes note of a look-up that found nothing.
  void missed(const BatchResult& result);
  [[nodiscard]] const CacheReport& report() const { return report_; }

 private:
  Result<void> open_folder(const BatchOptions& options);

  /// Takes note of whether the caches were of use to a plant.
  void note_use(const BatchResult& result);

  JobCache jobs_;
  std::optional<Descriptor> lock_;                // keeps other programs out of the folder
  std::unique_ptr<HttpCache> server_;             // where jobs_ points to
  std::unique_ptr<std::vector<KnownKey>> known_;  // likewise
  CacheReport report_;
};

}  // namespace coppice::bake
