#include "batch_caches.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
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

Result<CacheLock> CacheLock::take(const fs::path& cache, bool shares) {
  const fs::path path = cache / "lock";
  CacheLock lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (lock.file_ < 0) return system_error("cannot use the cache", path, errno);
  struct flock whole {};
  whole.l_type = shares ? F_RDLCK : F_WRLCK;
  whole.l_whence = SEEK_SET;
  if (::fcntl(lock.file_, F_SETLK, &whole) == 0) return lock;
  if (errno != EACCES && errno != EAGAIN) return system_error("cannot lock", path, errno);
  return Error{Status::io, "another bake-all is writing to this folder", Error::kNoOffset, cache.string()};
}

CacheLock::CacheLock(CacheLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

CacheLock::~CacheLock() {
  if (file_ >= 0) ::close(file_);
}

Result<void> BatchCaches::open_folder(const BatchOptions& options) {
  const fs::path& shared = options.shared.location.folder;
  const bool is_read = options.shared.mode == CacheMode::read;
  folder_report_.where = shared.empty() ? options.cache.string() : shared.string();
  if (!shared.empty() && !is_read) {
    Result<void> usable = make_folder(shared);
    if (usable) usable = try_writing(shared / "entry");
    if (usable) jobs_.folder = shared;
    if (usable) return {};
    folder_report_.trouble = usable.error().message() + "; " + options.cache.string() + " was used instead";
  }
  if (!shared.empty() && is_read) jobs_.behind = shared;
  std::error_code error;
  if (!jobs_.behind.empty() && !fs::is_directory(shared, error)) folder_report_.trouble = "there is no such folder";
  COPPICE_CHECK(make_folder(options.cache));
  jobs_.folder = options.cache;
  COPPICE_TRY(lock, CacheLock::take(options.cache, options.other_batches));
  lock_.emplace(std::move(lock));
  return {};
}

Result<BatchCaches> BatchCaches::open(const BatchOptions& options, std::size_t job_count) {
  BatchCaches caches;
  caches.jobs_.needed = false;
  if (options.cache.empty()) return caches;
  COPPICE_CHECK(caches.open_folder(options));
  if (options.explain) {
    caches.known_ = std::make_unique<std::vector<KnownKey>>(known_keys(caches.jobs_.folder));
    if (!caches.jobs_.behind.empty())
      for (KnownKey& known : known_keys(caches.jobs_.behind)) caches.known_->push_back(std::move(known));
    caches.jobs_.known = caches.known_.get();
  }
  const SharedCache& shared = options.shared;
  if (shared.location.url.empty()) return caches;
  auto courier =
      CacheCourier::start({shared.location.url, shared.credentials, shared.mode, caches.jobs_.folder, job_count, shared.only_indexed});
  if (courier) {
    caches.courier_.emplace(*std::move(courier));
    caches.jobs_.line = caches.courier_->line();
  } else {
    caches.folder_report_.where = shared.location.url;
    caches.folder_report_.trouble = courier.error().message();
  }
  return caches;
}

void BatchCaches::ended(const BatchResult& result) {
  constexpr std::size_t kMostFailures = 3;
  if (result.outcome == BatchOutcome::cached) ++folder_report_.found;
  if (result.outcome != BatchOutcome::baked) return;
  ++folder_report_.lacking;
  if (result.cache_failure.empty()) {
    failures_in_a_row_ = 0;
    ++folder_report_.sent;
    return;
  }
  ++folder_report_.unsent;
  if (folder_report_.trouble.empty()) folder_report_.trouble = result.cache_failure;
  if (++failures_in_a_row_ >= kMostFailures) jobs_.keeps = false;
}

CacheReport BatchCaches::finish() {
  if (!courier_) return folder_report_;
  CacheReport report = courier_->finish();
  if (!folder_report_.trouble.empty()) report.trouble += (report.trouble.empty() ? "" : "; ") + folder_report_.trouble;
  report.unsent += folder_report_.unsent;
  return report;
}

}  // namespace coppice::bake
