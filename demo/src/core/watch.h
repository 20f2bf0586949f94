#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace forest {

/// Files that may change while the program runs.
struct Watch {
  struct Stamp {
    std::filesystem::file_time_type time;
    std::uintmax_t bytes = 0;
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };
  struct File {
    std::string path;
    Stamp shown, last;  ///< when it was read last; when it was looked at last
  };
  std::vector<File> files;
};

Watch watch_files(const std::vector<std::string>& paths);

/// Indices of files that have changed since they were shown and not since the last look: what is still being written is left for the next
/// look. They count as shown from now on. One that is missing has not changed.
std::vector<std::size_t> changed_files(Watch& watch);

}  // namespace forest
