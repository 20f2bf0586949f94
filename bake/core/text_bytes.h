#pragma once

// Text as bytes, bytes as text, and JSON as text. A view lives as long as its source.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace coppice::bake {

inline std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

inline std::string_view as_text(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// JSON on one line. In both, bytes that are not UTF-8 are replaced.
template <class Json>
std::string json_line(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// JSON as a file: indented, with a newline at its end.
template <class Json>
std::string json_file(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace coppice::bake
