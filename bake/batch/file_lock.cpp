#include "file_lock.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "temporary_file.h"

namespace coppice::bake {

Result<FileLock> FileLock::take(const std::filesystem::path& path, LockKind kind, const char* busy) {
  FileLock lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (lock.file_ < 0) return system_error("cannot use the folder", path, errno);
  struct flock whole {};
  whole.l_type = kind == LockKind::shared ? F_RDLCK : F_WRLCK;
  whole.l_whence = SEEK_SET;
  if (::fcntl(lock.file_, F_SETLK, &whole) == 0) return lock;
  if (errno != EACCES && errno != EAGAIN) return system_error("cannot lock", path, errno);
  return Error{Status::io, busy, Error::kNoOffset, path.parent_path().string()};
}

FileLock::FileLock(FileLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

FileLock::~FileLock() {
  if (file_ >= 0) ::close(file_);
}

}  // namespace coppice::bake
