#pragma once

// What a person says about materials, for the importer to obey: `--leaf-material`, `--wood-material` and `--classes F.json`.

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Pieces of the materials whose name `material` is found in are `part`, if they have so many triangles.
struct ClassRule {
  std::string material = {};  ///< regular expression (name_pattern.h), searched (not anchored, case matters)
  PlantPart part = PlantPart::leaf;
  std::uint32_t min_triangles = 0;
  std::uint32_t max_triangles = std::numeric_limits<std::uint32_t>::max();
  std::string source = {};  ///< what to call the rule in messages: "--leaf-material", "oak.json: classes[2]"
};

/// Reads the rules of a classes file:
///   { "classes": [ { "material": "REGEX", "class": "leaf" | "wood" | "drop", "min_triangles": N, "max_triangles": N }, ... ] }
/// The last two are optional.
/// name    of the file, for messages
/// errors  bad_file: not JSON (offset: the byte), or a key that is missing, unknown or of the wrong type; `detail` names file and key
Result<std::vector<ClassRule>> parse_class_rules(std::string_view json, const std::string& name);

/// A rule as it applies to one material.
struct MaterialRule {
  PlantPart part = PlantPart::leaf;
  std::uint32_t min_triangles = 0;
  std::uint32_t max_triangles = std::numeric_limits<std::uint32_t>::max();
  std::string source = {};  ///< of the ClassRule
};

/// [materials.size()] the rules that apply to each, in the order given: the first whose triangle counts fit decides.
/// warnings  gets a line for each rule that applies to no material
/// errors    invalid_argument: not a regular expression; `detail` begins with the rule's source
Result<std::vector<std::vector<MaterialRule>>> apply_class_rules(std::span<const ClassRule> rules, const std::vector<Material>& materials,
                                                                 std::vector<std::string>& warnings);

}  // namespace coppice::bake
