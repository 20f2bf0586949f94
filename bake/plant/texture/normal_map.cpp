#include "normal_map.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "coppice/format.h"
#include "srgb.h"
#include "texture_mips.h"

namespace coppice::bake {

namespace {

std::uint8_t byte_from_signed(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(0.5f * value + 0.5f, 0.0f, 1.0f) * 255.0f));
}

std::span<std::uint8_t, 4> texel_of(Image& image, std::size_t index) {
  return std::span<std::uint8_t, 4>(image.rgba.data() + 4 * index, 4);
}

Image blank_map(std::uint32_t width, std::uint32_t height) {
  return {width, height, std::vector<std::uint8_t>(std::size_t{width} * height * 4), true};
}

Image halved(const Image& map) {
  Image half = blank_map(std::max(1u, map.width / 2), std::max(1u, map.height / 2));
  for (std::uint32_t y = 0; y < half.height; ++y)
    for (std::uint32_t x = 0; x < half.width; ++x) {
      const MipFootprint columns = mip_footprint(x, map.width), rows = mip_footprint(y, map.height);
      glm::vec3 sum(0.0f);
      for (std::uint32_t row = rows.first; row < rows.last; ++row)
        for (std::uint32_t column = columns.first; column < columns.last; ++column)
          sum += normal_of(std::span<const std::uint8_t, 4>(map.rgba.data() + 4 * (std::size_t{row} * map.width + column), 4));
      write_normal(sum, texel_of(half, std::size_t{y} * half.width + x));
    }
  return half;
}

}  // namespace

glm::vec3 normal_of(std::span<const std::uint8_t, 4> texel) {
  return glm::vec3(texel[0], texel[1], texel[2]) * (2.0f / 255.0f) - 1.0f;
}

void write_normal(const glm::vec3& normal, std::span<std::uint8_t, 4> texel) {
  const float length = glm::length(normal);
  const glm::vec3 unit = normal.z >= 0.0f && length > 1e-6f ? normal / length : glm::vec3(0.0f, 0.0f, 1.0f);
  for (int axis = 0; axis < 3; ++axis) texel[static_cast<std::size_t>(axis)] = byte_from_signed(unit[axis]);
  texel[3] = 255;
}

Image normal_map_within(Image map, std::uint32_t max_side_px) {
  while (std::max(map.width, map.height) > max_side_px) map = halved(map);
  return map;
}

std::vector<Image> normal_map_levels(const Image& map) {
  std::vector<Image> levels = {normal_map_within(map, COPPICE_MAX_TEXTURE_SIDE)};
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halved(levels.back()));
  return levels;
}

Image stored_normal_map(const Image& map) {
  Image stored{map.width, map.height, map.rgba};
  for (std::size_t i = 0; i < stored.rgba.size(); i += 4) {
    const float green = srgb_from_linear(static_cast<float>(map.rgba[i + 1]) / 255.0f);
    stored.rgba[i] = stored.rgba[i + 2] = 0;
    stored.rgba[i + 1] = static_cast<std::uint8_t>(std::lround(green * 255.0f));
    stored.rgba[i + 3] = map.rgba[i];
  }
  return stored;
}

Image normal_map_from_stored(const Image& stored) {
  Image map = blank_map(stored.width, stored.height);
  for (std::size_t i = 0; i < stored.rgba.size(); i += 4) {
    const float x = static_cast<float>(stored.rgba[i + 3]) / 127.5f - 1.0f;
    const float y = 2.0f * linear_from_srgb(static_cast<float>(stored.rgba[i + 1]) / 255.0f) - 1.0f;
    write_normal({x, y, std::sqrt(std::max(0.0f, 1.0f - x * x - y * y))}, texel_of(map, i / 4));
  }
  return map;
}

}  // namespace coppice::bake
