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

std::optional<unsigned> hex_digit(char c) {
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
  const char lower = static_cast<char>(c | 0x20);
  if (lower >= 'a' && lower <= 'f') return static_cast<unsigned>(lower - 'a' + 10);
  return {};
}

/// "a%20b" -> "a b"
std::string percent_decoded(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto high = uri[i] == '%' && i + 2 < uri.size() ? hex_digit(uri[i + 1]) : std::nullopt;
    const auto low = high ? hex_digit(uri[i + 2]) : std::nullopt;
    text += low ? static_cast<char>(*high * 16 + *low) : uri[i];
    if (low) i += 2;
  }
  return text;
}

/// Adds a file as it is, or that there is none. A pipe or device is nothing that a glTF can be in.
Result<void> add_file(Checksum& checksum, const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    checksum.add("missing");
    return {};
  }
  COPPICE_TRY(bytes, read_file(path));
  checksum.add("file");
  checksum.add(bytes);
  return {};
}

}  // namespace

std::string options_text(const BakeOptions& options) {
  // Every member by name: one that is added later does not compile until it is written below, or shown to change nothing. Of an option
  // that is a path the file's bytes belong into bake_key.
  const auto& [metric, view_count, thread_count, import, collapse, textures, crown_normals, leaf_meshes] = options;
  const auto& [leaf_material, wood_material, classes, require_leaves, up, metres_per_unit] = import;
  const auto& [resolution_px, count_background, candidate_count] = collapse;
  static_cast<void>(thread_count);    // same bytes for any number
  static_cast<void>(require_leaves);  // without leaves there are no bytes

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
  if (leaf_material) line("leaf_material", *leaf_material);
  if (wood_material) line("wood_material", *wood_material);
  for (const ClassRule& rule : classes)
    line("class", std::to_string(static_cast<int>(rule.part)) + " " + std::to_string(rule.min_triangles) + " " +
                      std::to_string(rule.max_triangles) + " " + rule.material);
  line("up", up == UpAxis::z ? "z" : "y");
  line("unit", std::to_string(std::bit_cast<std::uint64_t>(metres_per_unit)));
  return text;
}

std::vector<std::filesystem::path> referred_files(std::span<const std::uint8_t> gltf, const std::filesystem::path& folder) {
  std::string_view text = json_text(gltf);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const nlohmann::json root = nlohmann::json::parse(text, nullptr, false);
  std::vector<std::filesystem::path> files;
  std::vector<const nlohmann::json*> open{&root};
  while (!open.empty()) {
    const nlohmann::json& value = *open.back();
    open.pop_back();
    if (!value.is_structured()) continue;
    for (const auto& item : value.items()) {
      open.push_back(&item.value());
      if (!value.is_object() || item.key() != "uri" || !item.value().is_string()) continue;
      const auto& uri = item.value().get_ref<const std::string&>();
      if (!uri.starts_with("data:")) files.push_back(folder / percent_decoded(uri));
    }
  }
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

Result<std::string> bake_key(const std::filesystem::path& input, const BakeOptions& options) {
  COPPICE_TRY(bytes, read_file(input));
  Checksum checksum;
  checksum.add("baker " + std::to_string(kBakeVersion) + " format " + std::to_string(COPPICE_FORMAT_VERSION));
  checksum.add(options_text(options));
  checksum.add(input.filename().string());
  checksum.add(bytes);
  const std::filesystem::path folder = input.parent_path();
  for (const std::filesystem::path& file : referred_files(bytes, folder)) {
    checksum.add(file.lexically_relative(folder).string());
    COPPICE_CHECK(add_file(checksum, file));
  }
  return checksum.text();
}

}  // namespace coppice::bake
