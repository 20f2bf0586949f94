#pragma once

#include <array>
#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace coppice::bake {

/// Reads all of a text as a number, whatever the locale. No blanks, no plus sign. Returns nothing for other text or if the number does not
/// fit a T.
template <typename T>
std::optional<T> number_of(std::string_view text) {
  T number{};
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, number);
  return error == std::errc() && end == last ? std::optional<T>(number) : std::nullopt;
}

/// Writes values as printf does, at most 511 bytes.
template <class... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 512> text{};
  static_cast<void>(std::snprintf(text.data(), text.size(), format, values...));
  return text.data();
}

}  // namespace coppice::bake
