#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <vector>

#include "result.h"

namespace coppice::bake {

/// Writes a temporary file beside `path`, flushes it to disk and renames it over `path`: a reader, or a killed process, never meets half a
/// file. On failure the temporary file is removed and what was at `path` stays. A symbolic link is followed, not replaced.
/// errors  io: names the path and the operating system's reason; `path` is a folder, a device or a pipe
/// thread  any; two writers of one path each write a whole file, the last one stays
Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

/// Removes what processes that were killed inside write_file_atomically left in a folder: temporary files whose process is no more.
/// A folder that cannot be read has none.
void remove_abandoned_temporaries(const std::filesystem::path& folder);

/// The whole file, or its first `max_bytes`: no more is read.
/// errors  io: names the path and the operating system's reason
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path,
                                            std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max());

}  // namespace coppice::bake
