#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "result.h"

namespace coppice {

/// Says whether a glTF or a scene, which a stranger may have made, may name files outside its folder.
enum class OutsideFiles : std::uint8_t { refused, allowed };

/// True if `name`, relative to a folder, stays in it: it is not absolute, and no ".." leads above the folder. Only the text is checked, not
/// the file system.
bool stays_inside(std::string_view name);

/// Returns the file that `name`, relative to `folder`, names: absolute, with every symlink followed, and in `folder` or below it. With this
/// an asset of a stranger reaches no other file.
/// errors  invalid_argument: outside the folder; io: no such file, or the system's reason. `detail` has the name
Result<std::filesystem::path> resolve_inside(const std::filesystem::path& folder, const std::filesystem::path& name);

/// Does the same for a path that is not relative to `folder`. name: used in errors
Result<std::filesystem::path> resolve_below(const std::filesystem::path& folder, const std::filesystem::path& path,
                                            const std::string& name);

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
