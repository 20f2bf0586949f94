#pragma once

#include <cstdint>
#include <filesystem>

#include "result.h"

namespace coppice::bake {

enum class LockKind : std::uint8_t {
  alone,  ///< nobody else has the lock
  shared  ///< others who share it may have it too
};

/// A lock on a file, which other machines of a network file system see too. The process holds it until this is destroyed; processes that it
/// forks do not.
class FileLock {
 public:
  /// Makes the file if it is missing. busy: the message of the error where another process has the lock.
  /// errors  io
  static Result<FileLock> take(const std::filesystem::path& path, LockKind kind, const char* busy);
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

 private:
  explicit FileLock(int file) : file_(file) {}
  int file_;
};

}  // namespace coppice::bake
