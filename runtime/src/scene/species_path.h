#pragma once

#include <string>
#include <string_view>

#include "result.h"

namespace coppice {

/// The folder that the plants of a scene must be in.
struct AssetFolder {
  std::string root;            ///< plants are in it or below; empty: the scene's folder
  bool allow_outside = false;  ///< plants may be anywhere
  bool real_files = false;     ///< paths are the file system's: symlinks are followed before the check
};

/// Checks that the scene at `scene_path` may use the plant `species`, a path relative to the scene's folder.
/// errors  invalid_argument: outside; io: real_files, and there is no such file. `detail` has the species
Result<void> check_species_path(const AssetFolder& folder, std::string_view scene_path, std::string_view species);

}  // namespace coppice
