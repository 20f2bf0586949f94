#include "cache_upkeep.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "atomic_file.h"
#include "bake_cache.h"
#include "cache_index.h"
#include "cache_listing.h"
#include "http_transfers.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

// Of a folder.

/// A file that is no entry's, and is older, is of no writer any more.
constexpr std::int64_t kStrayAge_s = 3600;

struct FolderContents {
  std::vector<ListedEntry> entries;  ///< modified_s: last use
  std::vector<fs::path> strays;      ///< plants without a record
};

std::int64_t modified_s(const fs::path& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? static_cast<std::int64_t>(status.st_mtime) : 0;
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
  if (entry.modified_s == 0) return;
  stats.oldest_s = stats.oldest_s == 0 ? entry.modified_s : std::min(stats.oldest_s, entry.modified_s);
  stats.newest_s = std::max(stats.newest_s, entry.modified_s);
}

Result<CacheStats> folder_stats(const fs::path& folder) {
  COPPICE_TRY(contents, contents_of(folder));
  CacheStats stats;
  stats.stray_files = contents.strays.size();
  for (const ListedEntry& entry : contents.entries) {
    count(stats, entry);
    const auto record = read_file(record_file(folder, entry.key));
    std::string version = "unknown";
    for (const KeyPart& part : record ? parts_of_record(*record) : std::vector<KeyPart>())
      if (part.kind == "baker") version = part.value;
    ++stats.versions[version];
  }
  return stats;
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

Result<CacheVerification> verify_folder(const fs::path& folder, bool remove_damaged,
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
    } else if (!entry) {
      verification.unreadable.push_back(listed.key);
    }
    progress(verification.entries, contents.entries.size());
  }
  return verification;
}

/// Used longest ago first; of those used in the same second in order of their keys.
void sort_by_use(std::vector<ListedEntry>& entries) {
  std::ranges::sort(entries, [](const ListedEntry& a, const ListedEntry& b) {
    return a.modified_s != b.modified_s ? a.modified_s < b.modified_s : a.key < b.key;
  });
}

Result<CachePruning> prune_folder(const fs::path& folder, std::uint64_t most_bytes) {
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
    if (pruning.bytes <= most_bytes) break;
    if (modified_s(record_file(folder, entry.key)) != entry.modified_s) continue;  // somebody uses it now
    COPPICE_CHECK(remove_entry(folder, entry.key));
    --pruning.entries;
    pruning.bytes -= entry.bytes;
    ++pruning.removed_entries;
    pruning.removed_bytes += entry.bytes;
  }
  return pruning;
}

// Of a server.

/// Patient: nobody waits for it but the person who called.
constexpr double kPatience_s = 15.0;

class Server {
 public:
  explicit Server(const CachePlace& place) : url_(place.location.url), transfers_(place.credentials, 8) {}

  HttpAnswer ask(HttpRequest request) {
    std::optional<HttpAnswer> answer;
    start(std::move(request), [&answer](HttpAnswer got) { answer = std::move(got); });
    while (!answer) transfers_.step(1.0);
    return *std::move(answer);
  }
  void start(HttpRequest request, HttpTransfers::Done done) {
    request.stall_seconds = kPatience_s;
    request.stall_bytes = 1;
    transfers_.start(std::move(request), std::move(done));
  }
  void finish() {
    while (transfers_.count() > 0) transfers_.step(1.0);
  }
  Result<std::vector<ListedEntry>> list() {
    return list_cache([this](HttpRequest request) { return ask(std::move(request)); }, url_);
  }
  Result<std::vector<std::string>> list_records() {
    return coppice::bake::list_records([this](HttpRequest request) { return ask(std::move(request)); }, url_);
  }
  /// errors  io: with what the server says
  Result<void> remove(const std::string& url) {
    const HttpAnswer answer = ask({.method = HttpMethod::remove, .url = url});
    return checked(answer, "the server does not let entries be removed");
  }
  Result<void> write_index(const std::vector<ListedEntry>& entries) {
    CacheIndex index;
    for (const ListedEntry& entry : entries) index.emplace(entry.key, entry.bytes);
    const std::string text = index_text(index);
    HttpRequest request{.method = HttpMethod::put, .url = index_url(url_)};
    request.body.assign(text.begin(), text.end());
    return checked(ask(std::move(request)), "the server does not take an index");
  }
  [[nodiscard]] const std::string& url() const { return url_; }

 private:
  [[nodiscard]] Result<void> checked(const HttpAnswer& answer, const char* what) const {
    const bool done = answer.trouble == HttpTrouble::none && (is_success(answer.status) || is_absent(answer.status));  // or gone already
    if (done) return {};
    const std::string why = answer.trouble == HttpTrouble::none ? status_text(answer.status) : answer.why;
    return Error{Status::io, what, Error::kNoOffset, url_ + ": " + why};
  }

  std::string url_;
  HttpTransfers transfers_;
};

Result<CacheStats> server_stats(const CachePlace& place) {
  COPPICE_CHECK(load_http());
  Server server(place);
  COPPICE_TRY(entries, server.list());
  CacheStats stats;
  for (const ListedEntry& entry : entries) count(stats, entry);
  const HttpAnswer answer = server.ask({.method = HttpMethod::get, .url = index_url(server.url())});
  const auto index = read_index(as_text(answer.body));
  stats.has_index = answer.status == 200 && index;
  std::set<std::string> keys;
  for (const ListedEntry& entry : entries) keys.insert(entry.key);
  for (const std::string& key : keys) stats.unindexed += !stats.has_index || !index->contains(key) ? 1u : 0u;
  if (stats.has_index)
    for (const auto& [key, bytes] : *index) stats.misindexed += keys.contains(key) ? 0u : 1u;
  return stats;
}

Result<CacheVerification> verify_server(const CachePlace& place, bool remove_damaged,
                                        const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  COPPICE_CHECK(load_http());
  Server server(place);
  COPPICE_TRY(entries, server.list());
  CacheVerification verification;
  for (const ListedEntry& entry : entries)
    server.start({.method = HttpMethod::get, .url = entry_url(server.url(), entry.key)}, [&, key = entry.key](const HttpAnswer& answer) {
      ++verification.entries;
      verification.bytes += answer.body.size();
      if (answer.status != 200 || answer.trouble != HttpTrouble::none)
        verification.unreadable.push_back(key);
      else if (!read_bundle(answer.body, key))
        verification.damaged.push_back(key);
      progress(verification.entries, entries.size());
    });
  server.finish();
  std::ranges::sort(verification.damaged);
  std::ranges::sort(verification.unreadable);
  if (!remove_damaged || verification.damaged.empty()) return verification;
  for (const std::string& key : verification.damaged) {
    COPPICE_CHECK(server.remove(entry_url(server.url(), key)));
    ++verification.removed;
  }
  COPPICE_TRY(left, server.list());
  COPPICE_CHECK(server.write_index(left));
  return verification;
}

/// Removes the records of entries that are gone. One may have come, with its entry, since entries were listed.
Result<void> prune_records(Server& server, const std::vector<ListedEntry>& entries) {
  COPPICE_TRY(names, server.list_records());
  std::set<std::string> keys;
  for (const ListedEntry& entry : entries) keys.insert(entry.key);
  std::vector<std::pair<std::string, std::string>> unknown;  // names, and keys
  for (const std::string& name : names)
    server.start({.method = HttpMethod::get, .url = record_url(server.url(), name)}, [&, name](const HttpAnswer& answer) {
      if (answer.trouble != HttpTrouble::none || answer.status != 200) return;
      const std::string key = key_of(parts_of_record(answer.body));
      if (!keys.contains(key)) unknown.emplace_back(name, key);
    });
  server.finish();
  for (const auto& [name, key] : unknown) {
    if (!is_absent(server.ask({.method = HttpMethod::head, .url = entry_url(server.url(), key)}).status)) continue;
    COPPICE_CHECK(server.remove(record_url(server.url(), name)));
  }
  return {};
}

Result<CachePruning> prune_server(const CachePlace& place, std::uint64_t most_bytes) {
  COPPICE_CHECK(load_http());
  Server server(place);
  COPPICE_TRY(entries, server.list());
  sort_by_use(entries);
  CachePruning pruning;
  for (const ListedEntry& entry : entries) pruning.bytes += entry.bytes;
  std::size_t first_kept = 0;
  for (; first_kept < entries.size() && pruning.bytes > most_bytes; ++first_kept) {
    COPPICE_CHECK(server.remove(entry_url(server.url(), entries[first_kept].key)));
    pruning.bytes -= entries[first_kept].bytes;
    ++pruning.removed_entries;
    pruning.removed_bytes += entries[first_kept].bytes;
  }
  pruning.entries = entries.size() - first_kept;
  entries.erase(entries.begin(), entries.begin() + static_cast<std::ptrdiff_t>(first_kept));
  if (first_kept > 0) {
    COPPICE_CHECK(server.write_index(entries));
  }
  COPPICE_CHECK(prune_records(server, entries));
  return pruning;
}

}  // namespace

Result<CacheStats> cache_stats(const CachePlace& place) {
  return place.location.url.empty() ? folder_stats(place.location.folder) : server_stats(place);
}

Result<CacheVerification> verify_cache(const CachePlace& place, bool remove_damaged,
                                       const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  return place.location.url.empty() ? verify_folder(place.location.folder, remove_damaged, progress)
                                    : verify_server(place, remove_damaged, progress);
}

Result<CachePruning> prune_cache(const CachePlace& place, std::uint64_t most_bytes) {
  return place.location.url.empty() ? prune_folder(place.location.folder, most_bytes) : prune_server(place, most_bytes);
}

Result<std::uint64_t> rebuild_index(const CachePlace& place) {
  if (place.location.url.empty())
    return Error{Status::invalid_argument, "a cache in a folder has no index and needs none", Error::kNoOffset,
                 place.location.folder.string()};
  COPPICE_CHECK(load_http());
  Server server(place);
  COPPICE_TRY(entries, server.list());
  COPPICE_CHECK(server.write_index(entries));
  return std::uint64_t{entries.size()};
}

}  // namespace coppice::bake
