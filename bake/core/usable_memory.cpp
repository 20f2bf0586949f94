#include "usable_memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

#include "text_number.h"

namespace coppice::bake {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

/// The process's line of /proc/self/cgroup that is about version 2; empty where there is none.
std::string own_group() {
  std::ifstream file("/proc/self/cgroup");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("0::")) return line;
  return {};
}

}  // namespace

std::uint64_t group_memory_bytes(const std::filesystem::path& root, std::string_view group) {
  std::uint64_t least = kNoLimit;
  if (!group.starts_with("0::/")) return least;
  // Of a group outside those that the process sees only the outermost of these is known.
  const std::filesystem::path relative = std::filesystem::path(group.substr(4)).lexically_normal();
  std::filesystem::path folder = root / (relative.native().starts_with("..") ? std::filesystem::path() : relative);
  for (std::string text;; folder = folder.parent_path()) {
    if (std::ifstream(folder / "memory.max") >> text) least = std::min(least, number_of<std::uint64_t>(text).value_or(kNoLimit));
    if (folder.native().size() <= root.native().size() + 1) return least;
  }
}

std::uint64_t usable_memory_bytes() {
  // No process changes groups as it works.
  static const std::uint64_t group_bytes = group_memory_bytes("/sys/fs/cgroup", own_group());
  std::uint64_t machine_bytes = kNoLimit;
  const auto pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages > 0 && page_bytes > 0) machine_bytes = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
  rlimit space{};
  const bool has_limit = ::getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY;
  return std::min({machine_bytes, group_bytes, has_limit ? std::uint64_t{space.rlim_cur} : kNoLimit});
}

}  // namespace coppice::bake
