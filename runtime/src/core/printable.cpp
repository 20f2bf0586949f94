#include "printable.h"

#include <algorithm>
#include <cstdint>
#include <span>

#include "utf8.h"

namespace coppice {

namespace {

std::uint32_t code_point(std::span<const std::uint8_t> sequence) {
  if (sequence.size() == 1) return sequence[0];
  std::uint32_t code = sequence[0] & (0x7fu >> sequence.size());
  for (const std::uint8_t byte : sequence.subspan(1)) code = code << 6 | (byte & 0x3fu);
  return code;
}

bool is_control(std::uint32_t code) {
  struct Range {
    std::uint32_t first, last;
  };
  // C0, DEL and C1; marks, embeddings and overrides of direction; separators of lines; isolates of direction; the byte order mark.
  static constexpr Range kRanges[] = {{0x00, 0x1f},     {0x7f, 0x9f},     {0x61c, 0x61c},  {0x200e, 0x200f},
                                      {0x2028, 0x202e}, {0x2066, 0x2069}, {0xfeff, 0xfeff}};
  return std::ranges::any_of(kRanges, [code](const Range& range) { return code >= range.first && code <= range.last; });
}

/// Bytes of the printable character at the front of `text`; 0 if there is none.
std::size_t printable_length(std::span<const std::uint8_t> text) {
  const std::size_t length = utf8_sequence_length(text);
  return length == 0 || is_control(code_point(text.first(length))) ? 0 : length;
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
    const std::size_t kept = printable_length(bytes.subspan(at));
    shown.append(text.substr(at, kept));
    if (kept == 0) {
      const std::size_t hidden = std::max<std::size_t>(utf8_sequence_length(bytes.subspan(at)), 1);
      for (const std::uint8_t byte : bytes.subspan(at, hidden)) {
        shown += "\\x";
        shown += kDigits[byte >> 4];
        shown += kDigits[byte & 15];
      }
      at += hidden;
    }
    at += kept;
  }
  return shown;
}

bool is_printable(std::string_view text) {
  const auto bytes = as_bytes(text);
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t length = printable_length(bytes.subspan(at));
    if (length == 0) return false;
    at += length;
  }
  return true;
}

}  // namespace coppice
