#include "batch_caches.h"

#include <system_error>
#include <utility>

#include "atomic_file.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

Result<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return system_error("cannot make the cache", folder, error.value());
  return {};
}

}  // namespace

Result<void> BatchCaches::open_folder(const BatchOptions& options) {
  const fs::path& shared = options.shared.location.folder;
  const bool is_read = options.shared.mode == CacheMode::read;
  report_.where = shared.empty() ? options.cache.string() : shared.string();
  if (!shared.empty() && !is_read) {
    Result<void> usable = make_folder(shared);
    if (usable) usable = try_writing(shared / "entry");
    if (usable) jobs_.folder = shared;
    if (usable) return {};
    report_.trouble = usable.error().message() + "; " + options.cache.string() + " was used instead";
  }
  if (!shared.empty() && is_read) jobs_.read_only = shared;
  std::error_code error;
  if (!jobs_.read_only.empty() && !fs::is_directory(shared, error)) report_.trouble = "there is no such folder";
  COPPICE_CHECK(make_folder(options.cache));
  jobs_.folder = options.cache;
  const LockKind kind = options.other_batches ? LockKind::shared : LockKind::alone;
  COPPICE_TRY(lock, FileLock::take(options.cache / "lock", kind, "another bake-all is writing to this folder"));
  lock_.emplace(std::move(lock));
  return {};
}

Result<BatchCaches> BatchCaches::open(const BatchOptions& options) {
  BatchCaches caches;
  caches.jobs_.needed = false;
  if (options.cache.empty()) return caches;
  COPPICE_CHECK(caches.open_folder(options));
  if (options.explain) {
    caches.known_ = std::make_unique<std::vector<KnownKey>>(known_keys(caches.jobs_.folder));
    if (!caches.jobs_.read_only.empty())
      for (KnownKey& known : known_keys(caches.jobs_.read_only)) caches.known_->push_back(std::move(known));
    caches.jobs_.known = caches.known_.get();
  }
  const SharedCache& shared = options.shared;
  if (shared.location.url.empty()) return caches;
  caches.server_ = std::make_unique<HttpCache>(shared.location.url, shared.credentials);
  caches.jobs_.server = caches.server_.get();
  caches.jobs_.server_mode = shared.mode;
  caches.report_.where = shared.location.url;
  return caches;
}

void BatchCaches::note_use(const BatchResult& result) {
  const bool has_failed = !result.cache_failure.empty();
  if (has_failed && report_.trouble.empty()) report_.trouble = result.cache_failure;
  if (server_) {
    server_->count(has_failed);
    report_.gave_up = report_.gave_up || server_->is_off();
    return;
  }
  failures_in_a_row_ = has_failed ? failures_in_a_row_ + 1 : 0;
  if (failures_in_a_row_ >= kMaxServerFailures) jobs_.keeps = false;
}

void BatchCaches::ended(const BatchResult& result) {
  if (result.outcome == BatchOutcome::cached) ++report_.found;
  if (result.outcome != BatchOutcome::baked) return;
  if (!server_) ++report_.lacking;
  const bool takes = !server_ || jobs_.server_mode == CacheMode::read_write;
  if (takes) ++(result.cache_failure.empty() ? report_.sent : report_.unsent);
  note_use(result);
}

void BatchCaches::missed(const BatchResult& result) {
  ++report_.lacking;
  note_use(result);
}

CacheReport BatchCaches::report() const {
  return report_;
}

}  // namespace coppice::bake
