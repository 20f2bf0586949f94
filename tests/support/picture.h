#pragma once

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

}  // namespace coppice::test
