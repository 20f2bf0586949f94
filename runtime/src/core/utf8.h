#pragma once

#include <cstdint>
#include <span>

namespace coppice {

struct Utf8Character {
  std::size_t length = 0;  ///< bytes of its sequence; 0: it is not valid
  std::uint32_t code = 0;
};

/// Reads the character at the front of `text`. Overlong forms and surrogates are not valid.
/// text  not empty
inline Utf8Character utf8_character(std::span<const std::uint8_t> text) {
  const std::uint8_t lead = text[0];
  if (lead < 0x80) return {1, lead};
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < length) return {};
  std::uint32_t code = lead & (0x7fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((text[i] & 0xc0) != 0x80) return {};
    code = code << 6 | (text[i] & 0x3fu);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool outside = code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff);
  return overlong || outside ? Utf8Character{} : Utf8Character{length, code};
}

/// Returns the length of the valid sequence at the front of `text`, 0 if there is none. text: not empty
inline std::size_t utf8_sequence_length(std::span<const std::uint8_t> text) {
  return utf8_character(text).length;
}

}  // namespace coppice
