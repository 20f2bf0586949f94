#include "leaf_image.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "srgb.h"

namespace coppice::bake {
namespace {

constexpr int kSamplesPerSide = 4;

/// Distance of the rim from the midrib at a distance z from the stalk; 0 beyond the leaf.
float rim_at(const LeafOutline& outline, float z) {
  if (z <= 0.0f || z >= 1.0f) return 0.0f;
  std::array<float, 2> below{0.0f, 0.0f};
  for (const auto& above : outline.rim_xz) {
    if (z <= above[1]) return glm::mix(below[0], above[0], (z - below[1]) / (above[1] - below[1]));
    below = above;
  }
  return below[0] * (1.0f - z) / (1.0f - below[1]);
}

/// 1 on a vein, 0 away from it. Side veins leave the midrib at an angle and run to the rim.
float vein_at(const LeafPaint& paint, float x, float z) {
  const auto line = [](float distance, float width) { return std::clamp(1.5f - distance / width, 0.0f, 1.0f); };
  const float midrib = line(std::abs(x), paint.vein_width * (1.4f - z));
  if (paint.side_vein_count == 0) return midrib;
  const float spacing = 1.0f / static_cast<float>(paint.side_vein_count);
  const float along = (z - paint.side_vein_slope * std::abs(x)) / spacing;
  const float off = std::abs(along - std::round(along)) * spacing / std::hypot(1.0f, paint.side_vein_slope);
  const float side = along > 0.4f ? line(off, 0.55f * paint.vein_width) : 0.0f;
  return std::max(midrib, 0.7f * side);
}

std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

std::uint8_t srgb_byte(float linear) {
  return byte_of(srgb_from_linear(std::clamp(linear, 0.0f, 1.0f)));
}

}  // namespace

float half_width(const LeafOutline& outline) {
  float widest = 0.0f;
  for (const auto& [x, z] : outline.rim_xz) widest = std::max(widest, x);
  return widest;
}

Image paint_leaf(const LeafOutline& outline, const LeafPaint& paint) {
  Image image{.width = paint.width_px, .height = paint.height_px, .rgba = {}};
  const float half = half_width(outline);
  const float texel_x = 2.0f * half / static_cast<float>(paint.width_px);
  const float texel_z = 1.0f / static_cast<float>(paint.height_px);
  for (std::uint32_t row = 0; row < paint.height_px; ++row)
    for (std::uint32_t column = 0; column < paint.width_px; ++column) {
      float inside = 0.0f, vein = 0.0f;
      for (int sample = 0; sample < kSamplesPerSide * kSamplesPerSide; ++sample) {
        const int down = sample / kSamplesPerSide, right = sample % kSamplesPerSide;
        const float dx = (static_cast<float>(right) + 0.5f) / kSamplesPerSide;
        const float dy = (static_cast<float>(down) + 0.5f) / kSamplesPerSide;
        const float x = half * (2.0f * (static_cast<float>(column) + dx) / static_cast<float>(paint.width_px) - 1.0f);
        const float z = 1.0f - (static_cast<float>(row) + dy) / static_cast<float>(paint.height_px);
        inside += std::abs(x) <= texel_x + std::max({rim_at(outline, z - texel_z), rim_at(outline, z), rim_at(outline, z + texel_z)})
                      ? 1.0f
                      : 0.0f;
        vein += vein_at(paint, x, z);
      }
      constexpr float kSampleCount = kSamplesPerSide * kSamplesPerSide;
      const glm::vec3 color = glm::mix(paint.blade, paint.vein, vein / kSampleCount);
      // Colour does not stop at the outline: filtered samples there would pick up what lies outside.
      image.rgba.insert(image.rgba.end(), {srgb_byte(color.r), srgb_byte(color.g), srgb_byte(color.b), byte_of(inside / kSampleCount)});
    }
  return image;
}

}  // namespace coppice::bake
