#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "floor_to_int.h"
#include "plant.h"
#include "result.h"
#include "srgb.h"

namespace coppice::bake {

/// Index of the texel of a row or column at a texture coordinate: nearest, wrapping (repeat).
/// size  > 0
[[nodiscard]] inline std::uint32_t wrapped_texel(double coordinate, std::uint32_t size) {
  constexpr double kExact = 4503599627370496.0;  // 2^52: from there on every double is whole
  const bool is_whole = coordinate >= kExact || coordinate <= -kExact;
  const double wrapped = is_whole ? 0.0 : coordinate - static_cast<double>(floor_to_int<std::int64_t>(coordinate));
  return std::min(static_cast<std::uint32_t>(wrapped * size), size - 1);
}

/// First byte of the texel at a texture coordinate. The image must have texels.
[[nodiscard]] inline const std::uint8_t* texel_at(const Image& image, const glm::dvec2& uv) {
  return &image.rgba[4 * (std::size_t{wrapped_texel(uv.y, image.height)} * image.width + wrapped_texel(uv.x, image.width))];
}

[[nodiscard]] inline glm::vec3 linear_color(const std::uint8_t* texel) {
  return {linear_from_srgb8(texel[0]), linear_from_srgb8(texel[1]), linear_from_srgb8(texel[2])};
}

/// The holes of one material's image, nearest texel, wrapping (repeat). No image or alpha_cutoff 0: no holes.
struct AlphaMask {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> hole;  ///< [width * height] rows top to bottom, 1 where base_color.a * texel alpha < alpha_cutoff
  [[nodiscard]] bool is_hole(const glm::dvec2& uv) const {
    return !hole.empty() && hole[std::size_t{wrapped_texel(uv.y, height)} * width + wrapped_texel(uv.x, width)] != 0;
  }
};

/// One mask per material.
/// errors  invalid_argument: a material names an image that is not there, or whose rgba has the wrong size
Result<std::vector<AlphaMask>> alpha_masks(const std::vector<Material>& materials, const std::vector<Image>& images);

}  // namespace coppice::bake
