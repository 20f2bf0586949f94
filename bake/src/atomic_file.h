#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "result.h"

namespace coppice::bake {

/// Writes beside `path`, flushes to disk and renames over it: a reader, or a killed process, never leaves half a file.
/// errors  io: names the path and the operating system's reason
Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

/// The whole file.
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path);

}  // namespace coppice::bake
