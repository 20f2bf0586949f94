#include "watch.h"

#include <optional>
#include <system_error>
#include <utility>

namespace forest {
namespace {

std::optional<Watch::Stamp> stamp_of(const std::string& path) {
  std::error_code missing;
  const auto time = std::filesystem::last_write_time(path, missing);
  if (missing) return std::nullopt;
  const auto bytes = std::filesystem::file_size(path, missing);
  if (missing) return std::nullopt;
  return Watch::Stamp{time, bytes};
}

}  // namespace

Watch watch_files(const std::vector<std::string>& paths) {
  Watch watch;
  for (const std::string& path : paths) {
    const Watch::Stamp stamp = stamp_of(path).value_or(Watch::Stamp{});
    watch.files.push_back({path, stamp, stamp});
  }
  return watch;
}

std::vector<std::size_t> changed_files(Watch& watch) {
  std::vector<std::size_t> changed;
  for (std::size_t i = 0; i < watch.files.size(); ++i) {
    Watch::File& file = watch.files[i];
    const auto stamp = stamp_of(file.path);
    if (!stamp) continue;
    if (std::exchange(file.last, *stamp) != *stamp || file.shown == *stamp) continue;
    file.shown = *stamp;
    changed.push_back(i);
  }
  return changed;
}

}  // namespace forest
