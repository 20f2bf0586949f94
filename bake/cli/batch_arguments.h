#pragma once

// The options of bake-all for its caches and for a cluster, and how it follows tasks.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cluster_batch.h"
#include "result.h"

namespace CLI {
class App;
}

namespace coppice::bake {

struct CacheArguments {
  std::string where, mode = "read-write";
  bool none = false, explain = false;
};

/// The environment variable that names a shared cache where --cache does not.
inline constexpr const char* kCacheVariable = "COPPICE_CACHE";

/// Adds --cache, --cache-mode, --no-cache and --explain. `arguments` must outlive the command.
void add_cache_options(CLI::App& command, CacheArguments& arguments);

/// Throws CLI::ValidationError for options that do not go together.
void check_cache_arguments(const CacheArguments& arguments);

/// Fills in the caches of a batch that writes below `output`.
/// errors  as parse_cache_location and credentials_of_environment
Result<void> set_caches(const CacheArguments& arguments, const std::filesystem::path& output, BatchOptions& options);

/// The options of the shared cache, for commands that bake parts of the batch elsewhere; empty: there is none.
std::vector<std::string> shared_cache_options(const CacheArguments& arguments);

struct ClusterArguments {
  bool slurm = false, print = false;
  std::filesystem::path coppice;
  std::vector<std::string> sbatch_options;
};

/// Adds --slurm, --print, --coppice and the words after "--". `arguments` must outlive the command.
void add_cluster_options(CLI::App& command, ClusterArguments& arguments);

/// A hint for a command line that was refused because it lacks the -- before options of sbatch; else empty.
std::string sbatch_hint(const std::vector<std::string>& words);

/// Throws CLI::ValidationError for options that do not go together.
void check_cluster_arguments(const ClusterArguments& arguments);

/// Fills in what follows from the options and the plants: the program, options of sbatch, and the plants' list entries.
/// errors  io; invalid_argument: a path that JSON or a script cannot hold
Result<void> prepare_cluster_batch(const ClusterArguments& arguments, ClusterBatch& batch);

/// Bakes with a progress bar and lines about what was submitted and lost. Ctrl-C leaves, and the tasks go on.
/// returns, errors  bake_on_cluster
Result<std::optional<std::vector<BatchResult>>> follow_on_cluster(ClusterBatch& batch, bool quiet);

}  // namespace coppice::bake
