#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "result.h"
#include "temporary_file.h"

namespace coppice::bake {

/// Writes a temporary file beside `path`, flushes it to disk and renames it over `path`: a reader, or a killed process, never meets half a
/// file. On failure the temporary file is removed and what was at `path` stays. A symbolic link is followed as find_place says, or
/// replaced. What goes to /dev/null is gone.
/// errors  io: names the path and the operating system's reason; `path` is empty, a folder, another device or a pipe
/// thread  any; two writers of one path each write a whole file, the last one stays
Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes,
                                   LastLink last = LastLink::followed);

/// Does the same in a folder that is open.
Result<void> write_file_atomically(const FilePlace& place, std::span<const std::uint8_t> bytes);

/// The first half of write_file_atomically: writes the temporary file beside `path` to disk. publish() is the second half. Files that
/// belong together are all staged before the first is published.
/// errors  those of write_file_atomically
Result<TemporaryFile> stage_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes,
                                 LastLink last = LastLink::followed);

/// Whether a place is /dev/null, which takes any output and keeps none.
bool is_null_device(const FilePlace& place);
/// The error of an output that is neither a plain file nor /dev/null.
Error not_written(const std::filesystem::path& path);

enum class LockKind : std::uint8_t {
  alone,  ///< nobody else has the lock
  shared  ///< others who share it may have it too
};

/// Locks a file, which other machines of a network file system see too; makes it if it is missing. The process holds the lock until the
/// file is closed; processes that it forks do not.
/// busy    the message of the error where another process has the lock
/// errors  io
Result<Descriptor> lock_file(const std::filesystem::path& path, LockKind kind, const char* busy);

/// Creates the folder that will hold `path`, or the folder itself, and its missing parents. errors  io, as find_place
Result<void> make_folder_of(const std::filesystem::path& path);
Result<void> make_folder(const std::filesystem::path& folder);

/// Checks that write_file_atomically can write to `path`: makes the temporary file, removes it, and removes abandoned ones beside it
/// (temporary_file.h). What is at `path` stays.
/// errors  those of write_file_atomically that show before the bytes are written
Result<void> try_writing(const std::filesystem::path& path);

/// Size of a file in bytes; 0 if there is none.
std::uint64_t bytes_of_file(const std::filesystem::path& path);

inline constexpr std::uint64_t kWholeFile = ~std::uint64_t{0};

/// Reads a regular file, or its first `max_bytes`. It refuses pipes, devices and folders, and reads no more than the file's size at
/// opening, so that no read waits or goes on without end.
/// errors  io: names the path and the operating system's reason, or that it is not a plain file; out_of_memory
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes = kWholeFile);

enum class FileOwner : std::uint8_t { anybody, user };

/// Reads a file that this program wrote earlier, from a folder that others may write to: no symbolic link, and, where the contents do not
/// prove themselves, of the user or of root.
/// errors  as read_file; bad_file: another user's, or not a plain file
Result<std::vector<std::uint8_t>> read_kept_file(const std::filesystem::path& path, FileOwner owner, std::uint64_t max_bytes = kWholeFile);
Result<std::vector<std::uint8_t>> read_kept_file(const FilePlace& place, FileOwner owner, std::uint64_t max_bytes = kWholeFile);

}  // namespace coppice::bake
