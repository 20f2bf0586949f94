#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "file_place.h"
#include "result.h"

namespace coppice::bake {

/// An open file beside a target. publish() makes it the target; otherwise the destructor removes it. If the process may end without
/// destructors, remove_own_temporaries() removes it; remove_abandoned_temporaries() removes what a killed process left.
class TemporaryFile {
 public:
  /// Creates the file.
  /// errors  io: names the target and the operating system's reason
  /// thread  any
  static Result<TemporaryFile> create_beside(FilePlace target);
  /// No file: publish() does nothing.
  static TemporaryFile none(FilePlace target);
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile();

  /// Writes the file's whole contents and flushes them to disk. errors  io, as create_beside
  Result<void> write(std::span<const std::uint8_t> bytes);
  /// Renames the file over the target, also over a link. Allocates nothing unless that fails. errors  io, as create_beside
  Result<void> publish();
  /// The file itself, to add to after publish(). number  negative for none()
  Descriptor take_open_file() { return Descriptor(std::exchange(descriptor_, -1)); }
  /// The user whose file it is: on a network file system perhaps another than the process's. errors  io
  [[nodiscard]] Result<std::uint32_t> owner() const;

 private:
  TemporaryFile(FilePlace target, std::string name, std::size_t slot);

  FilePlace target_;
  std::string name_;  ///< in the target's folder; empty: it is no more
  std::size_t slot_;  ///< index into the table that remove_own_temporaries reads
  int descriptor_ = -1;
};

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
