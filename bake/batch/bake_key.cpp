#include "bake_key.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "coppice/format.h"
#include "occlusion_areas.h"
#include "option_table.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

constexpr const char* kMissing = "missing";

std::string checksum_text(std::span<const std::uint8_t> bytes) {
  return checksum_of(std::array{as_text(bytes)});
}

/// Checksums of files, each read once, however many references name it.
class FileStates {
 public:
  /// The checksum of as much of a file as a bake reads; kMissing where there is none.
  Result<std::string> state_of(const GltfReference& reference, const std::filesystem::path& folder, OutsideFiles outside) {
    const auto file = resolve_reference(folder, reference.uri, reference.place(), outside);
    if (!file && file.error().status != Status::io) return file.error();
    if (!file) return std::string(kMissing);
    const auto [known, is_new] = states_.try_emplace({*file, std::min(reference.used_bytes, bytes_of_file(*file))});
    if (!is_new) return known->second;
    COPPICE_TRY(bytes, read_file(*file, reference.used_bytes));
    return known->second = checksum_text(bytes);
  }

 private:
  std::map<std::pair<std::filesystem::path, std::uint64_t>, std::string> states_;  ///< by file and how much of it
};

}  // namespace

std::vector<KeyPart> option_parts(const BakeOptions& options) {
  // A member that is added later does not compile until it is counted here: it needs a row in bake_option_table(), or changes nothing, as
  // the number of threads.
  [[maybe_unused]] const auto& [o1, o2, o3, import, collapse, o6, o7, o8, o9, wind] = options;
  [[maybe_unused]] const auto& [i1, i2, i3, i4, i5, i6, i7, plant, i9, i10, i11] = import;
  [[maybe_unused]] const auto& [p1, p2, p3] = plant;
  [[maybe_unused]] const auto& [w1, w2] = wind;
  [[maybe_unused]] const auto& [c1, c2, c3] = collapse;

  std::vector<KeyPart> parts;
  for (const BakeOption& option : bake_option_table())
    if (const auto value = option.changes_result ? option.get(options) : std::nullopt)
      parts.push_back({"option", option.name, portable_text(*value)});
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
  FileStates states;
  for (const GltfReference& reference : referred_files(bytes)) {
    COPPICE_TRY(state, states.state_of(reference, input.parent_path(), options.import.outside_files));
    parts.push_back({"file", portable_text(percent_decoded(reference.uri)), std::move(state)});
  }
  return parts;
}

bool is_part_of(std::span<const KeyPart> parts, std::string_view uri, std::span<const std::uint8_t> bytes) {
  const std::string kind = uri.empty() ? "input" : "file", name = portable_text(percent_decoded(uri)), value = checksum_text(bytes);
  return std::ranges::any_of(parts, [&](const KeyPart& part) {
    return part.kind == kind && part.name == name && (part.value == value || (bytes.empty() && part.value == kMissing));
  });
}

Result<std::string> bake_key(const std::filesystem::path& input, const BakeOptions& options) {
  COPPICE_TRY(parts, bake_key_parts(input, options));
  return key_of(parts);
}

}  // namespace coppice::bake
