#include "class_rules.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "name_pattern.h"

namespace coppice::bake {
namespace {

using nlohmann::json;

Error bad_value(const char* what, const std::string& place) {
  return Error{Status::bad_file, what, Error::kNoOffset, place};
}

Result<std::string> read_text(const json& entry, const char* key, const std::string& place) {
  const auto found = entry.find(key);
  if (found == entry.end()) return bad_value("a key is missing", place + "." + key);
  if (!found->is_string()) return bad_value("not a string", place + "." + key);
  return found->get<std::string>();
}

Result<void> read_count(const json& entry, const char* key, const std::string& place, std::uint32_t& count) {
  const auto found = entry.find(key);
  if (found == entry.end()) return {};
  if (!found->is_number_unsigned() || found->get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
    return bad_value("not a whole number from 0 to 4294967295", place + "." + key);
  count = found->get<std::uint32_t>();
  return {};
}

std::optional<PlantPart> part_from_name(const std::string& name) {
  if (name == "leaf") return PlantPart::leaf;
  if (name == "wood") return PlantPart::wood;
  if (name == "drop") return PlantPart::dropped;
  return std::nullopt;
}

Result<ClassRule> read_rule(const json& entry, const std::string& place) {
  if (!entry.is_object()) return bad_value("not an object", place);
  constexpr std::array<const char*, 4> kKeys{"material", "class", "min_triangles", "max_triangles"};
  for (const auto& item : entry.items())
    if (std::find(kKeys.begin(), kKeys.end(), item.key()) == kKeys.end()) return bad_value("unknown key", place + "." + item.key());
  ClassRule rule;
  rule.source = place;
  COPPICE_CHECK(move_into(rule.material, read_text(entry, "material", place)));
  COPPICE_TRY(name, read_text(entry, "class", place));
  const std::optional<PlantPart> part = part_from_name(name);
  if (!part) return bad_value("not leaf, wood or drop", place + ".class is '" + name + "'");
  rule.part = *part;
  COPPICE_CHECK(read_count(entry, "min_triangles", place, rule.min_triangles));
  COPPICE_CHECK(read_count(entry, "max_triangles", place, rule.max_triangles));
  if (rule.min_triangles > rule.max_triangles) return bad_value("min_triangles is above max_triangles", place);
  return rule;
}

}  // namespace

Result<std::vector<ClassRule>> parse_class_rules(std::string_view text, const std::string& name) {
  json document;
  try {
    document = json::parse(text);
  } catch (const json::parse_error& error) {
    return Error{Status::bad_file, "not JSON", error.byte, name};
  } catch (const json::exception& error) {  // a number that fits no type
    return Error{Status::bad_file, "not JSON", Error::kNoOffset, name + ": " + error.what()};
  }
  if (!document.is_object()) return bad_value("not an object with the key classes", name);
  for (const auto& item : document.items())
    if (item.key() != "classes") return bad_value("unknown key", name + ": " + item.key());
  const auto classes = document.find("classes");
  if (classes == document.end()) return bad_value("a key is missing", name + ": classes");
  if (!classes->is_array()) return bad_value("not an array", name + ": classes");
  std::vector<ClassRule> rules;
  for (std::size_t i = 0; i < classes->size(); ++i) {
    COPPICE_TRY(rule, read_rule((*classes)[i], name + ": classes[" + std::to_string(i) + "]"));
    rules.push_back(std::move(rule));
  }
  return rules;
}

Result<std::vector<std::vector<MaterialRule>>> apply_class_rules(std::span<const ClassRule> rules, const std::vector<Material>& materials,
                                                                 std::vector<std::string>& warnings) {
  std::vector<std::vector<MaterialRule>> applied(materials.size());
  for (const ClassRule& rule : rules) {
    COPPICE_TRY(pattern, NamePattern::compile(rule.material, rule.source));
    bool applies = false;
    for (std::size_t m = 0; m < materials.size(); ++m) {
      if (!pattern.is_in(materials[m].name)) continue;
      applies = true;
      applied[m].push_back({rule.part, rule.min_triangles, rule.max_triangles, rule.source});
    }
    if (!applies) warnings.push_back(rule.source + ": no material matches '" + rule.material.substr(0, 64) + "'");
  }
  return applied;
}

}  // namespace coppice::bake
