#pragma once

// Views text as bytes, and bytes as text. A view lives as long as its source.

#include <cstdint>
#include <span>
#include <string_view>

namespace coppice::bake {

inline std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

inline std::string_view as_text(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace coppice::bake
