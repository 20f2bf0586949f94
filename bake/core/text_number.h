#pragma once

#include <algorithm>
#include <charconv>
#include <cstdarg>
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

/// Writes values as printf does.
[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char* format, ...) {
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  std::string text(static_cast<std::size_t>(std::max(0, std::vsnprintf(nullptr, 0, format, arguments))), ' ');
  static_cast<void>(std::vsnprintf(text.data(), text.size() + 1, format, again));
  va_end(again);
  va_end(arguments);
  return text;
}

}  // namespace coppice::bake
