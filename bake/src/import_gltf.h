#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

struct ImportOptions {
  /// ECMAScript regular expression, searched (not anchored) in material names; what matches is foliage.
  /// Without it: the names documented in `coppice bake --help`.
  std::optional<std::string> leaf_material;
};

/// Reads a glTF 2.0 .gltf or .glb: the default scene's triangles in metres, node transforms applied. Foliage triangles are split into
/// leaves: components connected through welded positions.
/// errors  io: unreadable; bad_file: not glTF, damaged, or an accessor out of range; unsupported: a required extension (named);
///         invalid_argument: leaf_material is not a regular expression, or no material matches it (the names are listed).
Result<Plant> import_gltf(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace coppice::bake
