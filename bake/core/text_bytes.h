#pragma once

// Text as bytes, and bytes as text: no copies, they live as long as what they are of.

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
