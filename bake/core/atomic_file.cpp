#include "atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace coppice::bake {
namespace {

Error not_plain(const char* what, const std::filesystem::path& path) {
  return Error{Status::io, what, Error::kNoOffset, path.string() + ": not a plain file"};
}

/// Finds the file to write: follows a symbolic link, and refuses what is not a plain file.
Result<std::filesystem::path> resolve_target(const std::filesystem::path& path) {
  if (path.empty()) return Error{Status::io, "cannot write", Error::kNoOffset, "the output has no name"};
  std::error_code error;
  std::filesystem::path target = std::filesystem::is_symlink(path, error) ? std::filesystem::weakly_canonical(path, error) : path;
  if (error == std::errc::not_enough_memory) return system_error("cannot write", path, error.value());
  if (error) target = path;
  struct stat status {};
  if (::stat(target.c_str(), &status) != 0) {
    if (errno != ENOENT) return system_error("cannot write", path, errno);
    if (!target.has_filename()) return system_error("cannot write", path, EISDIR);
    return target;
  }
  if (S_ISDIR(status.st_mode)) return system_error("cannot write", path, EISDIR);
  if (!S_ISREG(status.st_mode)) return not_plain("cannot write", path);
  return target;
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

}  // namespace

Result<TemporaryFile> stage_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  COPPICE_TRY(target, resolve_target(path));
  COPPICE_TRY(file, TemporaryFile::create_beside(target));
  COPPICE_CHECK(file.write(bytes));
  return file;
}

Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  COPPICE_TRY(file, stage_file(path, bytes));
  return file.publish();
}

Result<Descriptor> lock_file(const std::filesystem::path& path, LockKind kind, const char* busy) {
  Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (file.number() < 0) return system_error("cannot use the folder", path, errno);
  struct flock whole {};
  whole.l_type = kind == LockKind::shared ? F_RDLCK : F_WRLCK;
  whole.l_whence = SEEK_SET;
  if (::fcntl(file.number(), F_SETLK, &whole) == 0) return file;
  if (errno != EACCES && errno != EAGAIN) return system_error("cannot lock", path, errno);
  return Error{Status::io, busy, Error::kNoOffset, path.parent_path().string()};
}

Result<void> make_folder_of(const std::filesystem::path& path) {
  if (!path.has_parent_path() || !path.has_filename()) return {};  // without a name it is refused as a file
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  if (error) return system_error("cannot make the folder of", path, error.value());
  return {};
}

Result<void> try_writing(const std::filesystem::path& path) {
  COPPICE_TRY(target, resolve_target(path));
  remove_abandoned_temporaries(folder_of(target));
  COPPICE_CHECK(TemporaryFile::create_beside(target));
  return {};
}

std::uint64_t bytes_of_file(const std::filesystem::path& path) {
  std::error_code missing;
  const std::uintmax_t bytes = std::filesystem::file_size(path, missing);
  return missing ? 0 : bytes;
}

Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  // Without O_NONBLOCK a pipe would be waited for here, and a serial line.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (file.number() < 0) return system_error("cannot read", path, errno);
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return system_error("cannot read", path, errno);
  if (S_ISDIR(status.st_mode)) return system_error("cannot read", path, EISDIR);
  if (!S_ISREG(status.st_mode)) return not_plain("cannot read", path);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min(static_cast<std::uint64_t>(status.st_size), max_bytes)));
  COPPICE_CHECK(read_all(file.number(), bytes, path));
  return bytes;
}

}  // namespace coppice::bake
