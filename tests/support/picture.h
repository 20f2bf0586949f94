#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace coppice::test {

/// RGBA8, rows top to bottom, as stored in the attachment it was read from (sRGB attachments give sRGB bytes).
struct Picture {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::vector<std::uint8_t> rgba;  ///< [height_px * width_px * 4]

  /// First of the four bytes of a pixel.
  [[nodiscard]] const std::uint8_t* at(std::uint32_t x, std::uint32_t y) const { return rgba.data() + (std::size_t{y} * width_px + x) * 4; }
};

/// The left half, or with 1 the right one.
inline Picture half_of(const Picture& picture, std::uint32_t half) {
  Picture result{picture.width_px / 2, picture.height_px, {}};
  for (std::uint32_t y = 0; y < result.height_px; ++y)
    result.rgba.insert(result.rgba.end(), picture.at(half * result.width_px, y), picture.at((half + 1) * result.width_px, y));
  return result;
}

/// How many pixels there are whose four bytes `counts` holds for.
template <class Counts>
std::size_t count_pixels(const Picture& picture, const Counts& counts) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) count += counts(&picture.rgba[i]) ? 1u : 0u;
  return count;
}

/// Pixels that are no longer as the tests' attachments are cleared, white.
inline std::size_t drawn_pixels(const Picture& picture) {
  return count_pixels(picture, [](const std::uint8_t* rgba) { return std::any_of(rgba, rgba + 4, [](int byte) { return byte != 255; }); });
}

/// Root mean square of the differences of all bytes. a, b: of the same size
inline double rmse(const Picture& a, const Picture& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) sum += (a.rgba[i] - b.rgba[i]) * (a.rgba[i] - b.rgba[i]);
  return std::sqrt(sum / static_cast<double>(a.rgba.size()));
}

}  // namespace coppice::test
