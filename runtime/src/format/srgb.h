#pragma once

// The sRGB transfer function, 0..1 both ways.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace coppice {

inline float linear_from_srgb(float value) {
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

/// Converts a byte by a table, because pow would dominate the time of reading texels.
inline float linear_from_srgb8(std::uint8_t value) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
    return values;
  }();
  return table[value];
}

inline float srgb_from_linear(float value) {
  return value <= 0.0031308f ? value * 12.92f : 1.055f * std::pow(value, 1.0f / 2.4f) - 0.055f;
}

}  // namespace coppice
