#include "cache_upkeep.h"

#include <sys/stat.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <set>
#include <system_error>

#include "atomic_file.h"
#include "bake_cache.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

/// A file that is no entry's, and is older, is of no writer any more.
constexpr std::int64_t kStrayAge_s = 3600;

struct ListedEntry {
  std::string key;
  std::uint64_t bytes = 0;
  std::int64_t used_s = 0;  ///< last use, since 1970
};

struct FolderContents {
  std::vector<ListedEntry> entries;
  std::vector<fs::path> strays;  ///< plants without a record
};

std::int64_t modified_s(const fs::path& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 ? static_cast<std::int64_t>(status.st_mtime) : 0;
}

Result<FolderContents> contents_of(const fs::path& folder) {
  std::error_code error;
  std::set<std::string> records, plants;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string key = entry->path().stem().string();
    if (!is_key(key)) continue;
    if (entry->path().extension() == ".record") records.insert(key);
    if (entry->path().extension() == ".coppice") plants.insert(key);
  }
  if (error) return system_error("cannot read the cache", folder, error.value());
  FolderContents contents;
  for (const std::string& key : records) {
    const fs::path record = record_file(folder, key), plant = cached_file(folder, key);
    contents.entries.push_back({key, bytes_of_file(record) + bytes_of_file(plant), modified_s(record)});
  }
  for (const std::string& key : plants)
    if (!records.contains(key)) contents.strays.push_back(cached_file(folder, key));
  return contents;
}

void count(CacheStats& stats, const ListedEntry& entry) {
  ++stats.entries;
  stats.bytes += entry.bytes;
  if (entry.used_s == 0) return;
  stats.oldest_s = stats.oldest_s == 0 ? entry.used_s : std::min(stats.oldest_s, entry.used_s);
  stats.newest_s = std::max(stats.newest_s, entry.used_s);
}

/// The record first: without it there is no entry.
Result<void> remove_entry(const fs::path& folder, const std::string& key) {
  for (const fs::path& file : {record_file(folder, key), cached_file(folder, key)}) {
    std::error_code error;
    fs::remove(file, error);
    if (error) return system_error("cannot remove", file, error.value());
  }
  return {};
}

/// Used longest ago first; of those used in the same second in order of their keys.
void sort_by_use(std::vector<ListedEntry>& entries) {
  std::ranges::sort(entries,
                    [](const ListedEntry& a, const ListedEntry& b) { return a.used_s != b.used_s ? a.used_s < b.used_s : a.key < b.key; });
}

}  // namespace

Result<CacheStats> cache_stats(const fs::path& folder) {
  COPPICE_TRY(contents, contents_of(folder));
  CacheStats stats;
  stats.stray_files = contents.strays.size();
  for (const ListedEntry& entry : contents.entries) {
    count(stats, entry);
    const auto record = read_kept_file(record_file(folder, entry.key), FileOwner::anybody, kMaxRecordBytes + 1);
    std::string version = "unknown";
    for (const KeyPart& part : record ? parts_of_record(*record) : std::vector<KeyPart>())
      if (part.kind == "baker") version = part.value;
    ++stats.versions[version];
  }
  return stats;
}

Result<CacheVerification> verify_cache(const fs::path& folder, bool remove_damaged,
                                       const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  COPPICE_TRY(contents, contents_of(folder));
  CacheVerification verification;
  for (const ListedEntry& listed : contents.entries) {
    const auto entry = peek_cached(folder, listed.key);
    ++verification.entries;
    verification.bytes += listed.bytes;
    // What bakes read and prune removed meanwhile is not damaged.
    if (!entry && entry.error().status == Status::bad_file) {
      verification.damaged.push_back(listed.key);
      if (remove_damaged) {
        COPPICE_CHECK(remove_entry(folder, listed.key));
        ++verification.removed;
      }
    } else if (!entry && entry.error().status == Status::unsupported) {
      verification.too_large.push_back(listed.key);
    } else if (!entry) {
      verification.unreadable.push_back(listed.key);
    }
    progress(verification.entries, contents.entries.size());
  }
  return verification;
}

Result<CachePruning> prune_cache(const fs::path& folder, std::uint64_t max_bytes) {
  COPPICE_TRY(contents, contents_of(folder));
  remove_abandoned_temporaries(folder);
  const auto now_s = static_cast<std::int64_t>(std::time(nullptr));
  for (const fs::path& stray : contents.strays) {
    std::error_code gone;
    if (now_s - modified_s(stray) > kStrayAge_s) fs::remove(stray, gone);
  }
  CachePruning pruning;
  for (const ListedEntry& entry : contents.entries) pruning.bytes += entry.bytes;
  pruning.entries = contents.entries.size();
  sort_by_use(contents.entries);
  for (const ListedEntry& entry : contents.entries) {
    if (pruning.bytes <= max_bytes) break;
    if (modified_s(record_file(folder, entry.key)) != entry.used_s) continue;  // somebody uses it now
    COPPICE_CHECK(remove_entry(folder, entry.key));
    --pruning.entries;
    pruning.bytes -= entry.bytes;
    ++pruning.removed_entries;
    pruning.removed_bytes += entry.bytes;
  }
  return pruning;
}

}  // namespace coppice::bake
