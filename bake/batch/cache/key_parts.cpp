#include "key_parts.h"

#include <algorithm>
#include <cstdint>

#include "checksum.h"
#include "text_bytes.h"
#include "utf8.h"

namespace coppice::bake {
namespace {

bool is_utf8(std::string_view text) {
  std::span<const std::uint8_t> rest = bytes_of(text);
  while (!rest.empty()) {
    const std::size_t length = utf8_sequence_length(rest);
    if (length == 0) return false;
    rest = rest.subspan(length);
  }
  return true;
}

}  // namespace

std::string key_of(std::span<const KeyPart> parts) {
  Checksum checksum;
  for (const KeyPart& part : parts)
    for (const std::string& text : {part.kind, part.name, part.value}) checksum.add(text);
  return checksum.text();
}

bool is_key(std::string_view text) {
  constexpr std::size_t kDigits = 32;
  return text.size() == kDigits && std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

std::string portable_text(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbf\xbd", kDigits = "0123456789abcdef";
  if (is_utf8(text) && !text.starts_with(kMark)) return std::string(text);
  std::string portable(kMark);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    portable += kDigits[byte >> 4];
    portable += kDigits[byte & 15u];
  }
  return portable;
}

}  // namespace coppice::bake
