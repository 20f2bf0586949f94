#pragma once

#include <string>
#include <string_view>

#include "result.h"

namespace coppice {

/// Where the plants that a scene names may be.
struct AssetFolder {
  std::string root;            ///< in it or below; empty: the scene's folder
  bool allow_outside = false;  ///< anywhere
  bool real_files = false;     ///< paths are the file system's: symlinks are followed before they are judged
};

/// Whether the scene at `scene_path` may have the plant `species`, a path relative to the scene's folder.
/// errors  invalid_argument: outside; io: real_files, and there is no such file. `detail` has the species
Result<void> check_species_path(const AssetFolder& folder, std::string_view scene_path, std::string_view species);

}  // namespace coppice
