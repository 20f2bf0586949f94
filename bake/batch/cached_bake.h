#pragma once

// One plant of a batch: found in a cache, or baked and kept there.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "bake_batch.h"
#include "http_cache.h"
#include "result.h"
#include "why_baked.h"

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

/// Makes the folder of a cache if it is missing. errors  io
Result<void> make_cache(const std::filesystem::path& folder);

/// As bake_cached, with all caches of a batch.
BatchResult bake_one(const BatchPlant& plant, const JobCache& cache, const StageProgress& progress);

/// Finds a plant in the caches, the server's too. A plant that none of them has fails. A damaged entry of `cache.folder` stays for whoever
/// bakes the plant.
BatchResult load_one(const BatchPlant& plant, const JobCache& cache);

}  // namespace coppice::bake
