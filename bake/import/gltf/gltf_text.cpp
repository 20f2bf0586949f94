#include "gltf_text.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "atomic_file.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

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
