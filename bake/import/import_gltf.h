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
#include "gltf_references.h"
#include "gltf_variants.h"
#include "plant.h"
#include "plant_origin.h"
#include "result.h"

namespace coppice::bake {

/// The file's axis that points to the sky. glTF says +Y, but exporters forget to turn models that have +Z up.
enum class UpAxis { y, z };

/// Options of an import. Everything that they leave open, find_leaves.h decides.
struct ImportOptions {
  /// A regular expression (name_pattern.h), searched in material names (not anchored, case matters). Matches are leaves, whatever their
  /// shape; everything else is wood, unless `classes` decides otherwise.
  std::optional<std::string> leaf_material;
  /// The same for wood. find_leaves.h decides about materials that match neither.
  std::optional<std::string> wood_material;
  /// Rules that count after those two; the first match decides.
  std::vector<ClassRule> classes;
  UpAxis up = UpAxis::y;
  double metres_per_unit = 1.0;  ///< glTF says metres; finite and > 0
  /// n: the red of the vertex colours COLOR_n says how flexible a vertex is, 0 stiff .. 1 flexible, and is no tint.
  std::optional<std::uint32_t> wind_color_set;
  Origin origin = Origin::automatic;
  /// Which plant to take from a file that holds several, or one several times.
  PlantChoice plant;
  /// Whether buffers and images may be files outside the glTF's folder.
  OutsideFiles outside_files = OutsideFiles::refused;
  std::uint32_t max_source_triangles = 0;  ///< CostLimit::max_triangles (gltf_cost.h)
  /// Called in the importing thread with the bytes of each file that is read; may be empty.
  ReadObserver on_read = {};
};

/// The transform from the file's axes and unit to metres with +Y up. errors  invalid_argument: metres_per_unit is no length
Result<glm::dmat4> scene_from_file(const ImportOptions& options);

/// Reads a glTF 2.0 .gltf or .glb: takes the default scene's triangles, applies node transforms and instances, converts to metres with +Y
/// up and separates leaves from wood (find_leaves.h). Either may be empty. Lines become thin strips (gltf_lines.h). From a pack it takes
/// one plant (gltf_variants.h). It treats extensions as README.md says. Vertex colours tint their material and its triangles
/// (vertex_colors.h). The plant has only the materials and images in use. Plant::warnings lists what was dropped or read differently from
/// what the file asks for.
/// errors  `detail` begins with the file's name and names the place in it. io: the file or one it refers to is unreadable; bad_file: not
///         glTF, damaged, an index or accessor out of range, a position that is not finite; unsupported: another glTF version, a required
///         extension (named), more triangles than the limit, more than a plant may have; invalid_argument: a file outside the glTF's
///         folder, unless that is allowed, metres_per_unit is no length, a pattern is not a regular expression, or leaf_material matches
///         nothing (the materials are listed)
Result<Plant> import_gltf(const std::filesystem::path& path, const ImportOptions& options);

/// Lists what the file holds, and reads no more of it than choose_plant needs. errors  as import_gltf
Result<SourceContents> read_contents(const std::filesystem::path& path, const ImportOptions& options);

/// import_gltf for bytes in memory. `path` names them in messages; the files that they refer to are beside it.
Result<Plant> import_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& path, const ImportOptions& options);

}  // namespace coppice::bake
