#include "bake_key.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <string_view>
#include <system_error>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "checksum.h"
#include "coppice/format.h"
#include "occlusion_areas.h"

namespace coppice::bake {
namespace {

/// The JSON of a .gltf or .glb; empty for what is neither.
std::string_view json_text(std::span<const std::uint8_t> gltf) {
  constexpr std::size_t kJsonStart = 20;  // after the header and the head of the first chunk
  const std::string_view text(reinterpret_cast<const char*>(gltf.data()), gltf.size());
  if (!text.starts_with("glTF")) return text;
  if (text.size() < kJsonStart) return {};
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, gltf.data() + 12, sizeof bytes);
  return text.substr(kJsonStart, bytes);
}

/// As much of a file as a bake reads; nothing where there is none.
Result<std::optional<std::vector<std::uint8_t>>> state_of(const GltfReference& reference, const std::filesystem::path& folder,
                                                          OutsideFiles outside) {
  const auto file = resolve_reference(folder, reference.uri, reference.place(), outside);
  if (!file && file.error().status != Status::io) return file.error();
  if (!file) return std::optional<std::vector<std::uint8_t>>();
  COPPICE_TRY(bytes, read_file(*file, reference.used_bytes));
  return std::optional<std::vector<std::uint8_t>>(std::move(bytes));
}

}  // namespace

std::string options_text(const BakeOptions& options) {
  // Every member by name: one that is added later does not compile until it is written below, or shown to change nothing. Of an option
  // that is a path the file's bytes belong into bake_key.
  const auto& [metric, view_count, thread_count, import, collapse, textures, crown_normals, leaf_meshes, areas, wind] = options;
  const auto& [leaf_material, wood_material, classes, up, metres_per_unit, wind_color_set, plant, outside_files] = import;
  const auto& [node, variant, whole] = plant;
  const auto& [wind_moves, wind_stiffness] = wind;
  const auto& [resolution_px, count_background, candidate_count] = collapse;
  static_cast<void>(thread_count);   // same bytes for any number
  static_cast<void>(outside_files);  // nor with a file that is refused

  std::string text;
  const auto line = [&text](const char* name, const std::string& value) { text += std::string(name) + " " + value + "\n"; };
  line("metric", std::to_string(static_cast<int>(metric)));
  line("views", std::to_string(view_count));
  line("resolution", std::to_string(resolution_px));
  line("background", count_background ? "on" : "off");
  line("candidates", std::to_string(candidate_count));
  line("textures", std::to_string(static_cast<int>(textures)));
  line("crown_normals", std::to_string(std::bit_cast<std::uint32_t>(crown_normals)));
  line("leaf_meshes", leaf_meshes ? "on" : "off");
  line("wind", wind_moves ? std::to_string(std::bit_cast<std::uint32_t>(wind_stiffness)) : "none");
  if (wind_color_set) line("wind_weights", std::to_string(*wind_color_set));
  if (areas == Areas::vulkan) line("areas", "vulkan " + std::to_string(kMostMeasuredLeaves));
  if (leaf_material) line("leaf_material", *leaf_material);
  if (wood_material) line("wood_material", *wood_material);
  for (const ClassRule& rule : classes)
    line("class", std::to_string(static_cast<int>(rule.part)) + " " + std::to_string(rule.min_triangles) + " " +
                      std::to_string(rule.max_triangles) + " " + rule.material);
  if (node) line("node", *node);
  line("variant", whole ? "whole" : std::to_string(variant));
  line("up", up == UpAxis::z ? "z" : "y");
  line("unit", std::to_string(std::bit_cast<std::uint64_t>(metres_per_unit)));
  return text;
}

std::vector<GltfReference> referred_files(std::span<const std::uint8_t> gltf) {
  std::string_view text = json_text(gltf);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return find_references(nlohmann::json::parse(text, nullptr, false));
}

Result<std::string> bake_key(const std::filesystem::path& input, const BakeOptions& options) {
  COPPICE_TRY(bytes, read_file(input));
  Checksum checksum;
  checksum.add("baker " + std::to_string(kBakeVersion) + " format " + std::to_string(COPPICE_FORMAT_VERSION));
  checksum.add(options_text(options));
  if (options.areas == Areas::vulkan) {
    COPPICE_TRY(device, area_device_name());
    checksum.add(device);
  }
  checksum.add(input.filename().string());
  checksum.add(bytes);
  for (const GltfReference& reference : referred_files(bytes)) {
    checksum.add(percent_decoded(reference.uri));
    COPPICE_TRY(state, state_of(reference, input.parent_path(), options.import.outside_files));
    checksum.add(state.has_value() ? "file" : "missing");
    if (state) checksum.add(*state);
  }
  return checksum.text();
}

}  // namespace coppice::bake
