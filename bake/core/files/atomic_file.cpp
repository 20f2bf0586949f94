#include "atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

namespace coppice::bake {
namespace {

Error not_plain(Status status, const char* what, const std::filesystem::path& path) {
  return Error{status, what, Error::kNoOffset, path.string() + ": not a plain file"};
}

/// Whether a sticky folder keeps the user from replacing a file of another's.
bool is_kept_by_folder(const struct stat& file, const Descriptor& folder) {
  struct stat status {};
  const uid_t user = ::geteuid();
  if (user == 0 || file.st_uid == user || ::fstat(folder.number(), &status) != 0) return false;
  return (status.st_mode & S_ISVTX) != 0 && status.st_uid != user;
}

/// Refuses to write what cannot be replaced by a plain file.
Result<void> check_target(const FilePlace& place) {
  struct stat status {};
  if (::fstatat(place.folder.number(), place.name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
    return errno == ENOENT ? Result<void>() : system_error("cannot write", place.path, errno);
  if (S_ISDIR(status.st_mode)) return system_error("cannot write", place.path, EISDIR);
  if (!S_ISREG(status.st_mode) && !S_ISLNK(status.st_mode)) return not_written(place.path);
  return is_kept_by_folder(status, place.folder) ? system_error("cannot write", place.path, EPERM) : Result<void>();
}

Result<TemporaryFile> stage_at(FilePlace place, std::span<const std::uint8_t> bytes) {
  COPPICE_CHECK(check_target(place));
  COPPICE_TRY(file, TemporaryFile::create_beside(std::move(place)));
  COPPICE_CHECK(file.write(bytes));
  return file;
}

/// Fills `bytes` from the file's start.
Result<void> read_all(int descriptor, std::span<std::uint8_t> bytes, const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t count = ::read(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return system_error("cannot read", path, errno);
    if (count == 0) return Error{Status::io, "cannot read", Error::kNoOffset, path.string() + ": it became shorter while it was read"};
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

Result<std::vector<std::uint8_t>> read_opened(const Descriptor& file, const struct stat& status, const std::filesystem::path& path,
                                              std::uint64_t max_bytes) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min(static_cast<std::uint64_t>(status.st_size), max_bytes)));
  COPPICE_CHECK(read_all(file.number(), bytes, path));
  return bytes;
}

// Without O_NONBLOCK a pipe would be waited for, and a serial line.
constexpr int kReadFlags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;

}  // namespace

bool is_null_device(const FilePlace& place) {
  constexpr unsigned kMemoryDevices = 1, kNull = 3;
  struct stat status {};
  return ::fstatat(place.folder.number(), place.name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISCHR(status.st_mode) &&
         status.st_rdev == ::makedev(kMemoryDevices, kNull);
}

Error not_written(const std::filesystem::path& path) {
  return Error{Status::io, "cannot write", Error::kNoOffset, path.string() + ": not a plain file; name one, or /dev/null"};
}

Result<TemporaryFile> stage_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes, LastLink last) {
  COPPICE_TRY(place, find_place(path, last));
  return is_null_device(place) ? TemporaryFile::none(std::move(place)) : stage_at(std::move(place), bytes);
}

Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes, LastLink last) {
  COPPICE_TRY(file, stage_file(path, bytes, last));
  return file.publish();
}

Result<void> write_file_atomically(const FilePlace& place, std::span<const std::uint8_t> bytes) {
  COPPICE_TRY(target, beside(place, place.name));
  COPPICE_TRY(file, stage_at(std::move(target), bytes));
  return file.publish();
}

Result<Descriptor> lock_file(const std::filesystem::path& path, LockKind kind, const char* busy) {
  COPPICE_TRY(place, find_place(path, LastLink::stays));
  Descriptor file(::openat(place.folder.number(), place.name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666));
  if (file.number() < 0) return system_error("cannot use the folder", path, errno);
  struct flock whole {};
  whole.l_type = kind == LockKind::shared ? F_RDLCK : F_WRLCK;
  whole.l_whence = SEEK_SET;
  if (::fcntl(file.number(), F_SETLK, &whole) == 0) return file;
  if (errno != EACCES && errno != EAGAIN) return system_error("cannot lock", path, errno);
  return Error{Status::io, busy, Error::kNoOffset, path.parent_path().string()};
}

Result<void> make_folder_of(const std::filesystem::path& path) {
  if (!path.has_filename()) return {};  // it is refused as a file
  COPPICE_CHECK(find_place(path, LastLink::stays, MissingFolders::are_made));
  return {};
}

Result<void> make_folder(const std::filesystem::path& folder) {
  return make_folder_of(folder / ".");
}

Result<void> try_writing(const std::filesystem::path& path) {
  COPPICE_TRY(target, find_place(path));
  if (is_null_device(target)) return {};
  COPPICE_CHECK(check_target(target));
  remove_abandoned_temporaries("/proc/self/fd/" + std::to_string(target.folder.number()));
  COPPICE_CHECK(TemporaryFile::create_beside(std::move(target)));
  return {};
}

std::uint64_t bytes_of_file(const std::filesystem::path& path) {
  std::error_code missing;
  const std::uintmax_t bytes = std::filesystem::file_size(path, missing);
  return missing ? 0 : bytes;
}

Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  const Descriptor file(::open(path.c_str(), kReadFlags));
  if (file.number() < 0) return system_error("cannot read", path, errno);
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return system_error("cannot read", path, errno);
  if (S_ISDIR(status.st_mode)) return system_error("cannot read", path, EISDIR);
  if (!S_ISREG(status.st_mode)) return not_plain(Status::io, "cannot read", path);
  return read_opened(file, status, path, max_bytes);
}

Result<std::vector<std::uint8_t>> read_kept_file(const std::filesystem::path& path, FileOwner owner, std::uint64_t max_bytes) {
  COPPICE_TRY(place, find_place(path, LastLink::stays));
  return read_kept_file(place, owner, max_bytes);
}

Result<std::vector<std::uint8_t>> read_kept_file(const FilePlace& place, FileOwner owner, std::uint64_t max_bytes) {
  const std::filesystem::path& path = place.path;
  const Descriptor file(::openat(place.folder.number(), place.name.c_str(), kReadFlags | O_NOFOLLOW));
  if (file.number() < 0 && errno == ELOOP) return not_plain(Status::bad_file, "cannot read", path);
  if (file.number() < 0) return system_error("cannot read", path, errno);
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return system_error("cannot read", path, errno);
  if (!S_ISREG(status.st_mode)) return not_plain(Status::bad_file, "cannot read", path);
  if (owner == FileOwner::user && status.st_uid != ::geteuid() && status.st_uid != 0)
    return Error{Status::bad_file, "another user's file", Error::kNoOffset, path.string()};
  return read_opened(file, status, path, max_bytes);
}

}  // namespace coppice::bake
