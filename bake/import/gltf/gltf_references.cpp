#include "gltf_references.h"

#include <optional>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "printable.h"

namespace coppice::bake {
namespace {

std::optional<unsigned> hex_digit(char c) {
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
  const char lower = static_cast<char>(c | 0x20);
  if (lower >= 'a' && lower <= 'f') return static_cast<unsigned>(lower - 'a' + 10);
  return {};
}

/// Turns "file:///a/b" into "/a/b"; other text stays.
std::string_view without_file_scheme(std::string_view name) {
  constexpr std::string_view kScheme = "file:", kNoHost = "//";
  if (!name.starts_with(kScheme)) return name;
  name.remove_prefix(kScheme.size());
  if (name.starts_with(kNoHost)) name.remove_prefix(kNoHost.size());
  return name;
}

}  // namespace

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

Result<std::filesystem::path> resolve_reference(const std::filesystem::path& folder, std::string_view uri, const std::string& place,
                                                OutsideFiles outside) {
  constexpr std::size_t kShownChars = 256;
  const std::string shown = place + ": " + printable(uri.substr(0, kShownChars));
  const std::string decoded = percent_decoded(uri);
  const std::string_view name = without_file_scheme(decoded);
  if (name.empty() || name.find('\0') != std::string_view::npos)
    return Error{Status::bad_file, "not the name of a file", Error::kNoOffset, shown};
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

}  // namespace coppice::bake
