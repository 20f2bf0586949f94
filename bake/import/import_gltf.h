#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "asset_path.h"
#include "class_rules.h"
#include "gltf_variants.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// The file's axis that points to the sky. glTF says +Y; exporters forget to turn what was modelled with +Z up.
enum class UpAxis { y, z };

/// What is not said is found out: find_leaves.h.
struct ImportOptions {
  /// Regular expression (name_pattern.h), searched (not anchored, case matters) in material names: all that matches is leaves, whatever its
  /// shape, and all else is wood, save what `classes` says of it.
  std::optional<std::string> leaf_material;
  /// The same for wood; what matches neither is found out.
  std::optional<std::string> wood_material;
  /// Weighed after those two, first match first.
  std::vector<ClassRule> classes;
  UpAxis up = UpAxis::y;
  double metres_per_unit = 1.0;  ///< glTF says metres; finite and > 0
  /// n: the red of the vertex colours COLOR_n says how flexible a vertex is, 0 stiff .. 1 flexible, and is no tint.
  std::optional<std::uint32_t> wind_color_set;
  /// Of a file that holds several plants, or one several times.
  PlantChoice plant;
  /// Whether buffers and images may be files outside the glTF's folder.
  OutsideFiles outside_files = OutsideFiles::refused;
};

/// From the file's axes and unit to metres with +Y up. errors  invalid_argument: metres_per_unit is no length
Result<glm::dmat4> scene_from_file(const ImportOptions& options);

/// Reads a glTF 2.0 .gltf or .glb: the default scene's triangles, node transforms and instances applied, in metres with +Y up, taken apart
/// into leaves and wood (find_leaves.h), either of which may be none; points and lines are skipped. Of a pack one plant is taken
/// (gltf_variants.h). Extensions are treated as extension_rules() says. Vertex colours tint their material and its triangles
/// (vertex_colors.h). Materials and images are those in use. What was dropped or read differently from what the file asks for is told in
/// Plant::warnings. errors  `detail` begins with the file's name and names the place in it.
///         io: the file or one it refers to is unreadable; bad_file: not glTF, damaged, an index or accessor out of range, a position that
///         is not finite; unsupported: another glTF version, a required extension (named), more than a plant may have;
///         invalid_argument: a file outside the glTF's folder, unless that is allowed, metres_per_unit is no length, a pattern is not a
///         regular expression, or leaf_material matches nothing (the materials are listed).
Result<Plant> import_gltf(const std::filesystem::path& path, const ImportOptions& options);

/// What the file holds, without reading more of it than choose_plant needs. errors  as import_gltf
Result<SourceContents> read_contents(const std::filesystem::path& path, const ImportOptions& options);

/// The same as import_gltf of bytes in memory. `path` names them in messages; the files they refer to are beside it.
Result<Plant> import_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& path, const ImportOptions& options);

}  // namespace coppice::bake
