#include "gltf_references.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "printable.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

/// Turns "file:///a/b" into "/a/b"; other text stays.
std::string_view without_file_scheme(std::string_view name) {
  constexpr std::string_view kScheme = "file:", kNoHost = "//";
  if (!name.starts_with(kScheme)) return name;
  name.remove_prefix(kScheme.size());
  if (name.starts_with(kNoHost)) name.remove_prefix(kNoHost.size());
  return name;
}

constexpr std::size_t kJsonStart = 20;  // the header of a .glb and that of its first chunk come before

bool is_binary(std::span<const std::uint8_t> gltf) {
  return as_text(gltf).starts_with("glTF");
}

std::uint32_t json_bytes(std::span<const std::uint8_t> glb) {
  constexpr std::size_t kLength = 12;
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, glb.data() + kLength, sizeof bytes);
  return bytes;
}

}  // namespace

std::string percent_decoded(std::string_view uri) {
  std::string text;
  while (!uri.empty()) {
    const std::string_view digits = uri.substr(1, 2);
    unsigned char value = 0;
    const bool is_coded =
        uri[0] == '%' && digits.size() == 2 && std::from_chars(digits.data(), digits.data() + 2, value, 16).ptr == digits.data() + 2;
    text += is_coded ? static_cast<char>(value) : uri[0];
    uri.remove_prefix(is_coded ? 3 : 1);
  }
  return text;
}

std::string GltfReference::place() const {
  return (is_buffer ? "buffers[" : "images[") + std::to_string(index) + "].uri";
}

std::vector<GltfReference> find_references(const nlohmann::json& document) {
  std::vector<GltfReference> references;
  for (const char* name : {"buffers", "images"}) {
    const bool is_buffer = name == std::string_view("buffers");
    const auto objects = document.is_object() ? document.find(name) : document.end();
    if (objects == document.end() || !objects->is_array()) continue;
    for (std::size_t i = 0; i < objects->size(); ++i) {
      const nlohmann::json& object = (*objects)[i];
      if (!object.is_object() || !object.contains("uri") || !object["uri"].is_string()) continue;
      GltfReference reference{is_buffer, i, object["uri"], kMaxImageFileBytes};
      if (is_buffer && object.contains("byteLength") && object["byteLength"].is_number_unsigned())
        reference.used_bytes = object["byteLength"];
      if (!reference.uri.starts_with("data:")) references.push_back(std::move(reference));
    }
  }
  return references;
}

std::filesystem::path named_file(const std::filesystem::path& folder, std::string_view uri) {
  const std::string decoded = percent_decoded(uri);
  return folder / without_file_scheme(decoded);
}

Result<std::filesystem::path> resolve_reference(const std::filesystem::path& folder, std::string_view uri, const std::string& place,
                                                OutsideFiles outside) {
  constexpr std::size_t kShownChars = 256;
  const std::string shown = place + ": " + printable(uri.substr(0, kShownChars));
  const std::string decoded = percent_decoded(uri);
  const std::string_view name = without_file_scheme(decoded);
  if (name.empty() || has_control_character(name)) return Error{Status::bad_file, "not the name of a file", Error::kNoOffset, shown};
  const Error is_outside{Status::invalid_argument, "names a file outside the glTF's folder, which takes --allow-outside", Error::kNoOffset,
                         shown};
  const bool may_leave = outside == OutsideFiles::allowed;
  if (!may_leave && !stays_inside(name)) return is_outside;
  auto file = resolve_below(may_leave ? "/" : folder, folder / name, shown);
  if (!file) return file.error().status == Status::invalid_argument ? is_outside : file.error();
  std::error_code unreadable;
  if (!std::filesystem::is_regular_file(*file, unreadable))
    return Error{Status::io, "cannot open file", Error::kNoOffset, shown + ": not a plain file"};
  return file;
}

std::string_view gltf_text(std::span<const std::uint8_t> gltf) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  std::string_view text = as_text(gltf);
  if (!is_binary(gltf)) return text.substr(text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
  return text.size() < kJsonStart ? std::string_view() : text.substr(kJsonStart, json_bytes(gltf));
}

Result<std::vector<std::uint8_t>> read_gltf_text(const std::filesystem::path& file, std::uint64_t max_bytes) {
  COPPICE_TRY(head, read_file(file, kJsonStart));
  if (!is_binary(head) || head.size() < kJsonStart) return read_file(file, max_bytes);
  return read_file(file, std::min<std::uint64_t>(max_bytes, kJsonStart + std::uint64_t{json_bytes(head)}));
}

}  // namespace coppice::bake
