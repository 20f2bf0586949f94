#pragma once

// The options of bake-all for its caches, and what it prints about them.

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "bake_batch.h"

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

/// What a cache did, for the batch's JSON report.
nlohmann::ordered_json cache_json(const CacheReport& report);

/// One line on stderr where something was wrong with the cache: what, and what was lost by it.
void print_cache_trouble(const CacheReport& report);

/// "NAME: baked because option views: 42, was 20\n"; empty for a plant of which nothing is said.
std::string because_text(const std::string& name, const BatchResult& result);

}  // namespace coppice::bake
