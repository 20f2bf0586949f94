#include "batch_caches.h"

#include <system_error>
#include <utility>

#include "atomic_file.h"

namespace coppice::bake {

namespace fs = std::filesystem;

Result<void> BatchCaches::open_folder(const BatchOptions& options) {
  const fs::path& shared = options.shared.location.folder;
  const bool is_read = options.shared.mode == CacheMode::read;
  report_.where = shared.empty() ? options.cache.string() : shared.string();
  if (!shared.empty() && !is_read) {
    Result<void> usable = make_cache(shared);
    if (usable) usable = try_writing(shared / "entry");
    if (usable) jobs_.folder = shared;
    if (usable) return {};
    report_.trouble = usable.error().message() + "; " + options.cache.string() + " was used instead";
  }
  if (!shared.empty() && is_read) jobs_.read_only = shared;
  std::error_code error;
  if (!jobs_.read_only.empty() && !fs::is_directory(shared, error)) report_.trouble = "there is no such folder";
  COPPICE_CHECK(make_cache(options.cache));
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
  if (report_.trouble.empty()) report_.trouble = result.server_failure;
  if (report_.trouble.empty() && !result.folder_failure.empty())
    report_.trouble = (server_ ? "nothing is kept beside the outputs: " : "") + result.folder_failure;
  if (result.outcome == BatchOutcome::baked || !result.folder_failure.empty()) jobs_.folder_failures.count(!result.folder_failure.empty());
  if (!server_) return;
  server_->count(!result.server_failure.empty());
  report_.gave_up = report_.gave_up || server_->is_off();
}

void BatchCaches::ended(const BatchResult& result) {
  const bool is_baked = result.outcome == BatchOutcome::baked;
  const std::string& failure = server_ ? result.server_failure : result.folder_failure;
  if (result.outcome == BatchOutcome::cached) ++report_.found;
  if (is_baked && !server_) ++report_.lacking;
  if (server_ ? result.sent || !failure.empty() : is_baked) ++(failure.empty() ? report_.sent : report_.unsent);
  if (is_baked || !result.server_failure.empty() || !result.folder_failure.empty()) note_use(result);
}

void BatchCaches::missed(const BatchResult& result) {
  ++report_.lacking;
  note_use(result);
}

CacheReport BatchCaches::report() const {
  return report_;
}

}  // namespace coppice::bake
