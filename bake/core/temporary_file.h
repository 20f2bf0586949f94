#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "result.h"

namespace coppice::bake {

/// An open file beside a target that becomes the target, or is gone again when this is.
/// Where the process may end without destructors, remove_own_temporaries() takes them away; what a killed process leaves,
/// remove_abandoned_temporaries().
class TemporaryFile {
 public:
  /// errors  io: names the target and the operating system's reason
  /// thread  any
  static Result<TemporaryFile> create_beside(const std::filesystem::path& target);
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile();

  /// All that it will hold, flushed to disk. errors  io, as create_beside
  Result<void> write(std::span<const std::uint8_t> bytes);
  /// Renames it over the target. Allocates nothing unless that fails. errors  io, as create_beside
  Result<void> publish();

 private:
  TemporaryFile(std::filesystem::path target, std::filesystem::path path, std::size_t slot);

  std::filesystem::path target_, folder_, path_;
  std::size_t slot_;  ///< where remove_own_temporaries finds it
  int descriptor_ = -1;
};

/// The operating system's reason for what failed, about a path. errors  out_of_memory for ENOMEM, else io
Error system_error(const char* what, const std::filesystem::path& path, int reason);

/// All bytes to an open file. name: for the error
/// errors  io: the name and the operating system's reason
Result<void> write_all(int descriptor, std::span<const std::uint8_t> bytes, const std::filesystem::path& name);

/// Removes the temporary files that this process has now. Those of a process that it was forked from stay.
/// thread  any; async-signal-safe
void remove_own_temporaries() noexcept;

/// A signal handler: removes this process's temporary files, then lets the signal end the process.
void end_by_signal(int signal) noexcept;

/// The folder that a file is in: "." where the path names none.
std::filesystem::path folder_of(const std::filesystem::path& file);

/// Removes what processes that were killed while they wrote left in a folder: temporary files whose process is no more, and that nobody
/// holds open. A folder that cannot be read has none.
void remove_abandoned_temporaries(const std::filesystem::path& folder);

}  // namespace coppice::bake
