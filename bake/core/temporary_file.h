#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "result.h"

namespace coppice::bake {

/// An open file of the operating system, which is closed at the end. number  negative: there is none
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor();
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// An open file beside a target. publish() makes it the target; otherwise the destructor removes it. If the process may end without
/// destructors, remove_own_temporaries() removes it; remove_abandoned_temporaries() removes what a killed process left.
class TemporaryFile {
 public:
  /// Creates the file.
  /// errors  io: names the target and the operating system's reason
  /// thread  any
  static Result<TemporaryFile> create_beside(const std::filesystem::path& target);
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile();

  /// Writes the file's whole contents and flushes them to disk. errors  io, as create_beside
  Result<void> write(std::span<const std::uint8_t> bytes);
  /// Renames the file over the target. Allocates nothing unless that fails. errors  io, as create_beside
  Result<void> publish();

 private:
  TemporaryFile(std::filesystem::path target, std::filesystem::path path, std::size_t slot);

  std::filesystem::path target_, folder_, path_;
  std::size_t slot_;  ///< index into the table that remove_own_temporaries reads
  int descriptor_ = -1;
};

/// Makes the error of a failed system call on `path`, with the operating system's reason. Its status is out_of_memory for ENOMEM, else io.
Error system_error(const char* what, const std::filesystem::path& path, int reason);

/// Writes all bytes to an open file. name  names the file in the error
/// errors  io: the name and the operating system's reason
Result<void> write_all(int descriptor, std::span<const std::uint8_t> bytes, const std::filesystem::path& name);

/// Removes the temporary files that this process has now. Those of the process that forked it stay.
/// thread  any; async-signal-safe
void remove_own_temporaries() noexcept;

/// A signal handler: removes this process's temporary files, then lets the signal end the process.
void end_by_signal(int signal) noexcept;

/// The folder that a file is in: "." if the path names none.
std::filesystem::path folder_of(const std::filesystem::path& file);

/// Removes the temporary files that killed processes left in a folder: those whose process is gone and that nobody holds open. Does nothing
/// to a folder that cannot be read.
void remove_abandoned_temporaries(const std::filesystem::path& folder);

}  // namespace coppice::bake
