#pragma once

// One plant of a batch: found in a cache, or baked and kept there.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "bake_batch.h"
#include "cache_courier.h"
#include "result.h"
#include "why_baked.h"

namespace coppice::bake {

/// Where a job finds and keeps results.
struct JobCache {
  std::filesystem::path folder = {};  ///< there; empty: none
  std::filesystem::path behind = {};  ///< one that is only read; empty: none
  CourierLine line = {};              ///< to one on a server
  bool keeps = true;                  ///< false: the folder takes nothing any more
  bool needed = true;                 ///< a result that the folder does not take is a failure of the plant
  /// The folders' entries as they were before the batch: what explanations compare with; null: nobody wants any
  const std::vector<KnownKey>* known = nullptr;
};

/// The output, whose folder is there, is then `bytes`: written only if it is anything else. errors  io
Result<void> publish_bake(const std::filesystem::path& output, const std::vector<std::uint8_t>& bytes);

/// As bake_cached, with all caches of a batch.
BatchResult bake_one(const BatchPlant& plant, const JobCache& cache, const StageProgress& progress);

/// The same of a plant that a cache has; no other is baked: it has failed, because no cache has it. A damaged entry of `cache.folder`
/// stays for whoever bakes the plant.
BatchResult load_one(const BatchPlant& plant, const JobCache& cache);

}  // namespace coppice::bake
