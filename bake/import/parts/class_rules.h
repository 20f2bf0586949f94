#pragma once

// Rules in which a person says what a material's pieces are: `--leaf-material`, `--wood-material` and `--classes F.json`. The importer
// obeys them.

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Says that pieces are `part` if their material's name matches and their triangle count fits.
struct ClassRule {
  std::string material = {};  ///< regular expression (name_pattern.h), searched (not anchored, case matters)
  PlantPart part = PlantPart::leaf;
  std::uint32_t min_triangles = 0;
  std::uint32_t max_triangles = std::numeric_limits<std::uint32_t>::max();
  std::string source = {};  ///< names the rule in messages: "--leaf-material", "oak.json: classes[2]"
};

/// Reads the rules of a classes file:
///   { "classes": [ { "material": "REGEX", "class": "leaf" | "wood" | "drop", "min_triangles": N, "max_triangles": N }, ... ] }
/// The last two are optional.
/// name    the file's name, for messages
/// errors  bad_file: not JSON (offset: the byte), or a key that is missing, unknown or of the wrong type; `detail` names file and key
Result<std::vector<ClassRule>> parse_class_rules(std::string_view json, const std::string& name);

/// A rule as it applies to one material.
struct MaterialRule {
  PlantPart part = PlantPart::leaf;
  std::uint32_t min_triangles = 0;
  std::uint32_t max_triangles = std::numeric_limits<std::uint32_t>::max();
  std::string source = {};  ///< the ClassRule's
};

/// [materials.size()] Finds the rules that apply to each material, in the order given. The first whose triangle counts fit decides.
/// warnings  gets a line for each rule that applies to no material
/// errors    invalid_argument: not a regular expression; `detail` begins with the rule's source
Result<std::vector<std::vector<MaterialRule>>> apply_class_rules(std::span<const ClassRule> rules, const std::vector<Material>& materials,
                                                                 std::vector<std::string>& warnings);

}  // namespace coppice::bake
