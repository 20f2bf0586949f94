#pragma once

// What the caches of a batch have of it, before the rest is baked elsewhere.

#include <vector>

#include "bake_batch.h"
#include "result.h"

namespace coppice::bake {

/// Looks for plants in the caches of a batch and publishes those that are there; bakes none. Of a server it asks one question for all that
/// is there, the index, and fetches what that names, several at a time. After some seconds it stops where most have not been found: those
/// who bake read inputs faster together than this process alone.
/// options  its caches and cache_reported; others may use `cache` at the same time. A shared cache costs what it may cost a batch
/// returns  in the order of the plants: `cached`, or `failed` for one that is still to be baked
/// errors   io: `cache` cannot be made, or another process is using it alone
/// thread   the process must have no other threads (job_processes.h)
Result<std::vector<BatchResult>> load_batch(const std::vector<BatchPlant>& plants, BatchOptions options);

}  // namespace coppice::bake
