#pragma once

#include <sys/types.h>

#include <filesystem>
#include <set>
#include <utility>

#include "result.h"

namespace coppice::bake {

/// The files that a command reads and writes, told apart by where they are, and by what they are: two folders may be one.
class TakenPlaces {
 public:
  /// Whether none that was added before is the same. Nothing is the same as a device, or as no path. errors  out_of_memory
  Result<bool> add(const std::filesystem::path& path);

 private:
  std::set<std::filesystem::path> paths_;
  std::set<std::pair<dev_t, ino_t>> files_;
};

}  // namespace coppice::bake
