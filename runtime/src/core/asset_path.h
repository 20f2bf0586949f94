#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "result.h"

namespace coppice {

/// Files outside the folder of a glTF or a scene, which one that a stranger made may name.
enum class OutsideFiles : std::uint8_t { refused, allowed };

/// Whether `name`, relative to a folder, names something in it: it is not absolute, and no ".." leads above the folder. By the letters
/// alone: the file system is not asked.
bool stays_inside(std::string_view name);

/// The file that `name`, relative to `folder`, means: absolute, with every symlink followed, and in `folder` or below it. An asset that a
/// stranger made refers to files by names; with this they reach no other file.
/// errors  invalid_argument: outside the folder; io: no such file, or the system's reason. `detail` has the name
Result<std::filesystem::path> resolve_inside(const std::filesystem::path& folder, const std::filesystem::path& name);

/// The same of a path that is not relative to `folder`. name: what errors call it
Result<std::filesystem::path> resolve_below(const std::filesystem::path& folder, const std::filesystem::path& path,
                                            const std::string& name);

}  // namespace coppice
