#pragma once

// Finished bakes by their key. An entry is two files: KEY.coppice, which can be used as it is, and KEY.record, written after it, which
// makes it an entry and holds the checksum of both. Whoever deletes any of them, or the folder, loses time and nothing else.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "result.h"

namespace coppice::bake {

struct CachedBake {
  std::vector<std::uint8_t> bytes;  ///< the .coppice file
  std::uint32_t source_leaves = 0;
  std::uint64_t foliage_bytes = 0;
  std::vector<std::string> warnings;  ///< the importer's
};

/// The .coppice file of an entry.
std::filesystem::path cached_file(const std::filesystem::path& folder, const std::string& key);

/// key  as of bake_key
/// errors  io: there is no such entry, or it cannot be read; bad_file: it is damaged, and no entry any more
Result<CachedBake> load_cached(const std::filesystem::path& folder, const std::string& key);

/// Makes or replaces an entry. A process that is killed in here leaves none, or the old one, or the new one.
/// errors  io
Result<void> store_cached(const std::filesystem::path& folder, const std::string& key, const CachedBake& entry);

}  // namespace coppice::bake
