#include "printable.h"

#include <algorithm>
#include <cstdint>
#include <span>

#include "utf8.h"

namespace coppice {

namespace {

bool is_control(std::uint32_t code) {
  struct Range {
    std::uint32_t first, last;
  };
  // The ranges are C0; DEL and C1; marks, embeddings and overrides of direction; separators of lines; isolates of direction; the byte order
  // mark.
  static constexpr Range kRanges[] = {{0x00, 0x1f},     {0x7f, 0x9f},     {0x61c, 0x61c},  {0x200e, 0x200f},
                                      {0x2028, 0x202e}, {0x2066, 0x2069}, {0xfeff, 0xfeff}};
  return std::ranges::any_of(kRanges, [code](const Range& range) { return code >= range.first && code <= range.last; });
}

bool is_shown(const Utf8Character& character) {
  return character.length > 0 && !is_control(character.code);
}

std::span<const std::uint8_t> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

std::string printable(std::string_view text) {
  static constexpr char kDigits[] = "0123456789abcdef";
  const auto bytes = as_bytes(text);
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t at = 0; at < bytes.size();) {
    const Utf8Character character = utf8_character(bytes.subspan(at));
    const std::size_t length = std::max<std::size_t>(character.length, 1);
    if (is_shown(character)) {
      shown.append(text.substr(at, length));
    } else {
      for (const std::uint8_t byte : bytes.subspan(at, length)) {
        shown += "\\x";
        shown += kDigits[byte >> 4];
        shown += kDigits[byte & 15];
      }
    }
    at += length;
  }
  return shown;
}

bool is_printable(std::string_view text) {
  const auto bytes = as_bytes(text);
  for (std::size_t at = 0; at < bytes.size();) {
    const Utf8Character character = utf8_character(bytes.subspan(at));
    if (!is_shown(character)) return false;
    at += character.length;
  }
  return true;
}

bool has_control_character(std::string_view text) {
  return std::ranges::any_of(as_bytes(text), [](std::uint8_t byte) { return byte < 0x20 || byte == 0x7f; });
}

}  // namespace coppice
