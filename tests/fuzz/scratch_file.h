#pragma once

// For fuzz targets of what reads a path: the bytes as a file in a folder of this process, in memory where the system has such a place.

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include "check.h"

namespace coppice::test {

/// Made when first asked for; removed at a normal end.
inline const std::filesystem::path& scratch_folder() {
  static const std::filesystem::path made = [] {
    const std::filesystem::path memory = "/dev/shm";
    const std::filesystem::path parent = ::access(memory.c_str(), W_OK) == 0 ? memory : std::filesystem::temp_directory_path();
    const std::filesystem::path folder = parent / ("coppice_fuzz_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    static const std::string removed = folder.string();
    std::atexit([] {
      std::error_code ignored;
      std::filesystem::remove_all(removed, ignored);
    });
    return folder;
  }();
  return made;
}

/// Replaces the file; returns its path.
inline std::filesystem::path scratch_file(const std::string& name, std::span<const std::uint8_t> bytes) {
  const std::filesystem::path path = scratch_folder() / name;
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  COPPICE_ASSERT(stream.good());
  return path;
}

}  // namespace coppice::test
