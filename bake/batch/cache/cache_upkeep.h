#pragma once

// Upkeep of a cache in a folder: `coppice cache`. All of it may run beside bakes that use the cache. A server's cache is a folder of the
// server's, which its owner looks after with the same command.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "result.h"

namespace coppice::bake {

struct CacheStats {
  std::uint64_t entries = 0, bytes = 0;
  std::int64_t oldest_s = 0, newest_s = 0;        ///< last uses, seconds since 1970, UTC; 0: there is no entry
  std::map<std::string, std::uint64_t> versions;  ///< entries of each version of the baker
  std::uint64_t stray_files = 0;                  ///< files that belong to no entry, as a write that was cut short leaves them
};

/// errors  io: the folder cannot be read
Result<CacheStats> cache_stats(const std::filesystem::path& folder);

struct CacheVerification {
  std::uint64_t entries = 0, bytes = 0;
  std::vector<std::string> damaged;     ///< keys
  std::vector<std::string> unreadable;  ///< keys whose files cannot be read, or are gone meanwhile
  std::vector<std::string> too_large;   ///< keys of files over kMaxEntryBytes, which nobody reads
  std::uint64_t removed = 0;
};

/// Reads every entry that a bake would and compares checksums.
/// progress  called with the entries done and the number of entries
/// errors    io: the folder cannot be read, or a damaged entry cannot be removed
Result<CacheVerification> verify_cache(const std::filesystem::path& folder, bool remove_damaged,
                                       const std::function<void(std::uint64_t, std::uint64_t)>& progress);

struct CachePruning {
  std::uint64_t entries = 0, bytes = 0;  ///< that stay
  std::uint64_t removed_entries = 0, removed_bytes = 0;
};

/// Removes the entries used longest ago until `max_bytes` are left, and files that writes which were cut short left. A bake that meets a
/// removed entry bakes. errors  io: the folder cannot be read, or an entry cannot be removed
Result<CachePruning> prune_cache(const std::filesystem::path& folder, std::uint64_t max_bytes);

}  // namespace coppice::bake
