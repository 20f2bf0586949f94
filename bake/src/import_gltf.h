#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

struct ImportOptions {
  /// ECMAScript regular expression, searched (not anchored, case matters) in material names; what matches is foliage.
  /// Without it: names that contain one of leaf_names(), in any case.
  std::optional<std::string> leaf_material;
};

/// Parts of material names that mean foliage, in several languages: "leaf", "leaves", "foliage", ...
std::span<const std::string_view> leaf_names();

/// Reads a glTF 2.0 .gltf or .glb: the default scene's triangles, node transforms applied. Foliage triangles are split into leaves:
/// components connected through welded positions, within one node. Every other triangle is wood; points and lines are skipped. Materials
/// and images are those in use. What was dropped or read differently from what the file asks for is told in Plant::warnings.
/// errors  `detail` begins with the file's name and names the place in it.
///         io: the file or one it refers to is unreadable; bad_file: not glTF, damaged, an index or accessor out of range, a position that
///         is not finite; unsupported: another glTF version, a required extension (named), more than a plant may have;
///         invalid_argument: leaf_material is not a regular expression, or no material is foliage (the names are listed).
Result<Plant> import_gltf(const std::filesystem::path& path, const ImportOptions& options);

/// The same of bytes in memory. `path` names them in messages; the files they refer to are beside it.
Result<Plant> import_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& path, const ImportOptions& options);

}  // namespace coppice::bake
