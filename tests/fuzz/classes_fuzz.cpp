// libFuzzer: any bytes as a classes file are refused with a named error, or are rules that can be applied to materials or say why not.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "check.h"
#include "class_rules.h"

namespace {

using coppice::bake::ClassRule;
using coppice::bake::Material;

std::vector<Material> materials() {
  std::vector<Material> made(4);
  made[0].name = "Leaf_Oak.001";
  made[1].name = "bark";
  made[3].name = std::string(300, 'a') + "\xc3\xa9";
  return made;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<Material> plant_materials = materials();
  const auto rules = coppice::bake::parse_class_rules({reinterpret_cast<const char*>(data), size}, "rules.json");
  if (!rules) {
    COPPICE_ASSERT(rules.error().message().find("rules.json") != std::string::npos);
    return 0;
  }
  for (const ClassRule& rule : *rules) {
    COPPICE_ASSERT(rule.min_triangles <= rule.max_triangles);
    COPPICE_ASSERT(rule.source.starts_with("rules.json: classes["));
  }
  std::vector<std::string> warnings;
  const auto applied = coppice::bake::apply_class_rules(*rules, plant_materials, warnings);
  if (!applied) {
    COPPICE_ASSERT(applied.error().detail.starts_with("rules.json: classes["));
    return 0;
  }
  COPPICE_ASSERT(applied->size() == plant_materials.size());
  COPPICE_ASSERT(warnings.size() <= rules->size());
  for (const auto& of_material : *applied) COPPICE_ASSERT(of_material.size() <= rules->size());
  return 0;
}
