#pragma once

// Finished bakes by their key. An entry is two files: KEY.coppice, which can be used as it is, and KEY.record, which is written last. The
// record says what the key is made of and holds the checksum of both files. Whoever deletes any of them, or the folder, loses time and
// nothing else. Several processes and machines may use a folder at once: files are written whole or not at all, and equal keys mean equal
// bytes, so that it does not matter who writes last. Symbolic links are neither read nor written through.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "key_parts.h"
#include "result.h"

namespace coppice::bake {

struct CachedBake {
  std::vector<std::uint8_t> bytes;  ///< the .coppice file
  std::uint32_t source_leaves = 0;
  std::uint64_t foliage_bytes = 0;
  std::vector<std::string> warnings;  ///< the importer's
  std::vector<KeyPart> parts;         ///< that the key is of
};

/// The files of an entry. The record's time of modification is that of the entry's last use.
std::filesystem::path cached_file(const std::filesystem::path& folder, const std::string& key);
std::filesystem::path record_file(const std::filesystem::path& folder, const std::string& key);

/// A record holds warnings and the parts of the key. A larger file is no record, and is not even parsed.
inline constexpr std::uint64_t kMaxRecordBytes = std::uint64_t{4} << 20;
/// No bake takes a larger .coppice file from a cache.
inline constexpr std::uint64_t kMaxEntryBytes = std::uint64_t{1} << 30;

enum class DamagedEntry : std::uint8_t { is_removed, stays };

/// Reads an entry and marks it as used now, where that is allowed.
/// key      a text that key_of made
/// damaged  whether a damaged entry is removed: whoever bakes the plant next removes it, others leave it for them to notice
/// max_bytes  a larger .coppice file is not read
/// errors  io: there is no such entry, or it cannot be read; bad_file: it is damaged, one of another key, or not two plain files;
///         unsupported: it is larger than max_bytes
Result<CachedBake> load_cached(const std::filesystem::path& folder, const std::string& key, DamagedEntry damaged = DamagedEntry::is_removed,
                               std::uint64_t max_bytes = kMaxEntryBytes);

/// As load_cached, without a trace in the folder.
Result<CachedBake> peek_cached(const std::filesystem::path& folder, const std::string& key, std::uint64_t max_bytes = kMaxEntryBytes);

/// Makes or replaces an entry. A process that is killed in here leaves none, or the old one, or the new one.
/// errors  io
Result<void> store_cached(const std::filesystem::path& folder, const std::string& key, const CachedBake& entry);

/// The parts that a record lists for its key. Empty: it is no record.
std::vector<KeyPart> parts_of_record(std::span<const std::uint8_t> record);

/// An entry's two files: record_text() and CachedBake::bytes.
std::string record_text(const CachedBake& entry);
/// errors  bad_file: not the record of these bytes under that key
Result<CachedBake> read_entry(std::span<const std::uint8_t> record, std::vector<std::uint8_t> bytes, const std::string& key);

}  // namespace coppice::bake
