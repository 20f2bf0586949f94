#pragma once

// What is in a cache, whether it is whole, and less of it: `coppice cache`. All of it may run beside bakes that use the cache.

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cache_location.h"
#include "result.h"

namespace coppice::bake {

/// A cache and how it is reached.
struct CachePlace {
  CacheLocation location;
  CacheCredentials credentials;
};

struct CacheStats {
  std::uint64_t entries = 0, bytes = 0;
  std::int64_t oldest_s = 0, newest_s = 0;  ///< since 1970, UTC: last use; on a server when it was sent. 0: nothing there, or not said
  std::map<std::string, std::uint64_t> versions;  ///< entries of each version of the baker; of a folder alone
  std::uint64_t stray_files = 0;                  ///< of a folder: files of no entry, as a write that was cut short leaves
  bool has_index = false;                         ///< of a server
  std::uint64_t unindexed = 0, misindexed = 0;    ///< entries that the index lacks; that it names and are not there
};

/// errors  io: the folder cannot be read, or the server does not answer; unsupported: the server gives no listings in JSON, or
///         libcurl is missing
Result<CacheStats> cache_stats(const CachePlace& place);

struct CacheVerification {
  std::uint64_t entries = 0, bytes = 0;
  std::vector<std::string> damaged;     ///< keys
  std::vector<std::string> unreadable;  ///< keys: not to be had, or gone meanwhile
  std::uint64_t removed = 0;
};

/// Reads every entry and compares checksums.
/// remove_damaged  and the index of a server is written anew
/// progress        called with entries done and of how many
/// errors  as cache_stats; io: what is damaged cannot be removed
Result<CacheVerification> verify_cache(const CachePlace& place, bool remove_damaged,
                                       const std::function<void(std::uint64_t, std::uint64_t)>& progress);

struct CachePruning {
  std::uint64_t entries = 0, bytes = 0;  ///< that stay
  std::uint64_t removed_entries = 0, removed_bytes = 0;
};

/// Removes the entries used longest ago until `most_bytes` are left; on a server, which does not know of use, those sent longest ago. Of a
/// folder also what writes that were cut short left, of a server the records (cache_index.h) of entries that are gone. A bake that meets a
/// removed entry bakes.
/// errors  as cache_stats; io: an entry cannot be removed, with what the server says
Result<CachePruning> prune_cache(const CachePlace& place, std::uint64_t most_bytes);

/// Writes the index of a server anew, from its listings. returns  the number of entries
/// errors  as cache_stats; invalid_argument: it is a folder, which needs none; io: it cannot be written
Result<std::uint64_t> rebuild_index(const CachePlace& place);

}  // namespace coppice::bake
