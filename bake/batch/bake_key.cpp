#include "bake_key.h"

#include <cstdio>
#include <optional>
#include <system_error>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "checksum.h"
#include "coppice/format.h"
#include "gltf_text.h"
#include "occlusion_areas.h"

namespace coppice::bake {
namespace {

/// As much of a file as a bake reads; nothing where there is none.
Result<std::optional<std::vector<std::uint8_t>>> state_of(const GltfReference& reference, const std::filesystem::path& folder,
                                                          OutsideFiles outside) {
  const auto file = resolve_reference(folder, reference.uri, reference.place(), outside);
  if (!file && file.error().status != Status::io) return file.error();
  if (!file) return std::optional<std::vector<std::uint8_t>>();
  COPPICE_TRY(bytes, read_file(*file, reference.used_bytes));
  return std::optional<std::vector<std::uint8_t>>(std::move(bytes));
}

std::string checksum_text(std::span<const std::uint8_t> bytes) {
  Checksum checksum;
  checksum.add(bytes);
  return checksum.text();
}

/// No two numbers give the same text.
std::string exact(float number) {
  char text[32];
  static_cast<void>(std::snprintf(text, sizeof text, "%.9g", static_cast<double>(number)));
  return text;
}

std::string exact(double number) {
  char text[32];
  static_cast<void>(std::snprintf(text, sizeof text, "%.17g", number));
  return text;
}

const char* metric_text(Metric metric) {
  return metric == Metric::mi ? "mi" : metric == Metric::geometric ? "geometric" : "default";
}

const char* part_text(PlantPart part) {
  return part == PlantPart::leaf ? "leaf" : part == PlantPart::wood ? "wood" : "drop";
}

}  // namespace

std::vector<KeyPart> option_parts(const BakeOptions& options) {
  // Every member by name: one that is added later does not compile until it is written below, or shown to change nothing. Of an option
  // that is a path the file's bytes belong into bake_key_parts.
  const auto& [metric, view_count, thread_count, import, collapse, textures, crown_normals, leaf_meshes, areas, wind] = options;
  const auto& [leaf_material, wood_material, classes, up, metres_per_unit, wind_color_set, plant, outside_files] = import;
  const auto& [node, variant, whole] = plant;
  const auto& [wind_moves, wind_stiffness] = wind;
  const auto& [resolution_px, count_background, candidate_count] = collapse;
  static_cast<void>(thread_count);   // same bytes for any number
  static_cast<void>(outside_files);  // nor with a file that is refused

  std::vector<KeyPart> parts;
  const auto option = [&parts](const char* name, const std::string& value) { parts.push_back({"option", name, portable_text(value)}); };
  option("metric", metric_text(metric));
  option("views", view_count == 0 ? "by default" : std::to_string(view_count));
  option("resolution", std::to_string(resolution_px));
  option("background", count_background ? "on" : "off");
  option("candidates", std::to_string(candidate_count));
  option("textures", textures == TextureCoding::rgba8 ? "rgba8" : "bc");
  option("crown-normals", exact(crown_normals));
  option("leaf-meshes", leaf_meshes ? "on" : "off");
  option("wind-stiffness", wind_moves ? exact(wind_stiffness) : "no wind");
  if (wind_color_set) option("wind-weights", "COLOR_" + std::to_string(*wind_color_set));
  if (areas == Areas::vulkan) option("areas", "vulkan, at every step up to " + std::to_string(kMaxMeasuredLeaves) + " leaves");
  if (leaf_material) option("leaf-material", *leaf_material);
  if (wood_material) option("wood-material", *wood_material);
  for (const ClassRule& rule : classes)
    option("classes", std::string(part_text(rule.part)) + " of " + std::to_string(rule.min_triangles) + " to " +
                          std::to_string(rule.max_triangles) + " triangles, " + rule.material);
  if (node) option("node", *node);
  option("variant", whole ? "whole" : std::to_string(variant));
  option("up", up == UpAxis::z ? "z" : "y");
  option("unit", exact(metres_per_unit) + " m");
  return parts;
}

std::vector<GltfReference> referred_files(std::span<const std::uint8_t> gltf) {
  return find_references(nlohmann::json::parse(gltf_text(gltf), nullptr, false));
}

Result<std::vector<KeyPart>> bake_key_parts(const std::filesystem::path& input, const BakeOptions& options) {
  COPPICE_TRY(bytes, read_file(input));
  std::vector<KeyPart> parts{{"baker", "", std::to_string(kBakeVersion)}, {"format", "", std::to_string(COPPICE_FORMAT_VERSION)}};
  for (KeyPart& option : option_parts(options)) parts.push_back(std::move(option));
  if (options.areas == Areas::vulkan) {
    COPPICE_TRY(device, area_device_name());
    parts.push_back({"device", "", portable_text(device)});
  }
  parts.push_back({"name", "", portable_text(input.filename().string())});
  parts.push_back({"input", "", checksum_text(bytes)});
  for (const GltfReference& reference : referred_files(bytes)) {
    COPPICE_TRY(state, state_of(reference, input.parent_path(), options.import.outside_files));
    parts.push_back({"file", portable_text(percent_decoded(reference.uri)), state ? checksum_text(*state) : "missing"});
  }
  return parts;
}

Result<std::string> bake_key(const std::filesystem::path& input, const BakeOptions& options) {
  COPPICE_TRY(parts, bake_key_parts(input, options));
  return key_of(parts);
}

}  // namespace coppice::bake
