#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <vector>

#include "result.h"
#include "temporary_file.h"

namespace coppice::bake {

/// Writes a temporary file beside `path`, flushes it to disk and renames it over `path`: a reader, or a killed process, never meets half a
/// file. On failure the temporary file is removed and what was at `path` stays. A symbolic link is followed, not replaced.
/// errors  io: names the path and the operating system's reason; `path` is empty, a folder, a device or a pipe
/// thread  any; two writers of one path each write a whole file, the last one stays
Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

/// The first half of it: the temporary file, with all its bytes on disk. publish() is the second. For files that belong together.
/// errors  those of write_file_atomically
Result<TemporaryFile> stage_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

/// Makes the folder that `path` is to be in, and those above it, where they are missing. errors  io
Result<void> make_folder_of(const std::filesystem::path& path);

/// Tries whether write_file_atomically can write there, by making the temporary file, and removes abandoned ones beside it
/// (temporary_file.h). Leaves what is at `path` alone.
/// errors  those of write_file_atomically that can be known before
Result<void> try_writing(const std::filesystem::path& path);

/// Bytes of a file; 0 where there is none.
std::uint64_t bytes_of_file(const std::filesystem::path& path);

inline constexpr std::uint64_t kWholeFile = ~std::uint64_t{0};

/// A regular file, or its first `most_bytes`. Nothing else is waited for or read without end: pipes, devices and folders are refused, and
/// no more is read than the file's size was when it was opened.
/// errors  io: names the path and the operating system's reason, or that it is not a plain file; out_of_memory
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path, std::uint64_t most_bytes = kWholeFile);

}  // namespace coppice::bake
