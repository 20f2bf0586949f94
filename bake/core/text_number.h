#pragma once

#include <charconv>
#include <optional>
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

}  // namespace coppice::bake
