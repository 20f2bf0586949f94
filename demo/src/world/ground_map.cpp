#include "ground_map.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/gtc/packing.hpp>

#include "noise.h"

namespace forest {
namespace {

std::byte to_byte(float value) {
  return static_cast<std::byte>(std::lround(255 * std::clamp(value, 0.0f, 1.0f)));
}

float smooth(float from, float to, float value) {
  const float t = std::clamp((value - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

// Appends the mips of a square RGBA8 texture whose side is a power of two, each texel the mean of four.
void append_mips(Texture& texture) {
  texture.mip_count = static_cast<std::uint32_t>(std::bit_width(texture.side_px));
  std::size_t above = 0;
  for (std::uint32_t side = texture.side_px / 2; side > 0; side /= 2) {
    const std::size_t here = texture.texels.size();
    const std::size_t row = std::size_t{side} * 8;
    for (std::size_t i = 0; i < std::size_t{side} * side * 4; ++i) {
      const std::size_t first = above + i / 4 / side * 2 * row + i / 4 % side * 8 + i % 4;
      const auto at = [&](std::size_t offset) { return std::to_integer<unsigned>(texture.texels[first + offset]); };
      texture.texels.push_back(static_cast<std::byte>((at(0) + at(4) + at(row) + at(row + 4) + 2) / 4));
    }
    above = here;
  }
}

/// A square grid of optical depths, one value a texel.
struct DepthGrid {
  std::uint32_t side = 0;
  float extent_m = 0;
  std::vector<float> values;

  // A round crown of the given thickness, soft towards its edge.
  void add_disc(glm::vec2 center, float radius_m, float thickness) {
    const float texel_m = 2 * extent_m / static_cast<float>(side);
    const auto index = [&](float at) { return std::clamp(static_cast<int>((at + extent_m) / texel_m), 0, static_cast<int>(side) - 1); };
    for (int z = index(center.y - radius_m); z <= index(center.y + radius_m); ++z)
      for (int x = index(center.x - radius_m); x <= index(center.x + radius_m); ++x) {
        const glm::vec2 at = (glm::vec2(x, z) + 0.5f) * texel_m - extent_m;
        const float share = glm::distance(at, center) / radius_m;
        if (share < 1) values[static_cast<std::size_t>(z) * side + static_cast<std::size_t>(x)] += thickness * (1 - share * share);
      }
  }
};

}  // namespace

GroundMap make_ground_map(const Planting& planting, const glm::vec3& sun_direction, std::uint32_t seed) {
  constexpr std::uint32_t kSide = 512;
  GroundMap map;
  map.extent_m = 1.2f * planting.half_extent_m;
  map.among_others = planting.plants.size() > 1;
  DepthGrid sun{kSide, map.extent_m, std::vector<float>(kSide * kSide)};
  DepthGrid sky = sun;
  const glm::vec2 away = -glm::vec2(sun_direction.x, sun_direction.z) / std::max(sun_direction.y, 0.2f);
  for (const PlacedPlant& plant : planting.plants) {
    sun.add_disc(plant.position + away * 0.8f * plant.crown_radius_m, 1.05f * plant.crown_radius_m, 1.5f);
    sun.add_disc(plant.position + away * 0.2f * plant.crown_radius_m, 0.4f * plant.crown_radius_m, 0.9f);
    sky.add_disc(plant.position, 1.1f * plant.crown_radius_m, 0.8f);
  }
  map.texture.side_px = kSide;
  for (std::uint32_t z = 0; z < kSide; ++z)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const glm::vec2 at = (glm::vec2(x, z) + 0.5f) * (2 * map.extent_m / kSide) - map.extent_m;
      const float frayed_m = distance_from(planting.trail, at) + 0.35f * fractal_noise(at.x / 1.7f, at.y / 1.7f, 2, seed + 503);
      map.texture.texels.push_back(to_byte(std::exp(-sun.values[z * kSide + x])));
      map.texture.texels.push_back(to_byte(1 - smooth(0.35f, 1.15f, frayed_m)));
      map.texture.texels.push_back(to_byte(std::exp(-sky.values[z * kSide + x])));
      map.texture.texels.push_back(to_byte(0.5f + 0.75f * fractal_noise(at.x / 15, at.y / 15, 4, seed + 601)));
    }
  append_mips(map.texture);
  map.feet = make_feet(planting);
  return map;
}

namespace {

/// visit(texel's first byte, place along and across the leaf, -1..1) for texels of a leaf-shaped patch that may hang over the tile's edges.
template <class Visit>
void for_each_in_leaf(Texture& tile, glm::vec2 middle_px, float half_length_px, float turn_rad, const Visit& visit) {
  constexpr float kWidth = 0.42f;  // in lengths
  const auto side = static_cast<int>(tile.side_px);
  const glm::vec2 along(std::cos(turn_rad), std::sin(turn_rad));
  const int reach = static_cast<int>(half_length_px) + 1;
  for (int dz = -reach; dz <= reach; ++dz)
    for (int dx = -reach; dx <= reach; ++dx) {
      const glm::vec2 offset(dx, dz);
      const float u = glm::dot(offset, along) / half_length_px;
      const float v = (along.x * offset.y - along.y * offset.x) / half_length_px / kWidth;
      // Pointed at both ends, widest a little before the middle.
      if (std::abs(u) > 1 || std::abs(v) > (1 - u * u) * (1 - 0.25f * u)) continue;
      const int x = (static_cast<int>(middle_px.x) + dx + side) % side, z = (static_cast<int>(middle_px.y) + dz + side) % side;
      visit(4 * (static_cast<std::size_t>(z) * tile.side_px + static_cast<std::size_t>(x)), u, v);
    }
}

}  // namespace

Texture make_litter(std::uint32_t seed) {
  constexpr std::int32_t kSide = 512, kLeaves = 900;
  Texture tile;
  tile.side_px = kSide;
  tile.texels.assign(std::size_t{kSide} * kSide * 4, std::byte{0});
  for (std::size_t i = 3; i < tile.texels.size(); i += 4) tile.texels[i] = std::byte{255};
  for (std::int32_t i = 0; i < kLeaves; ++i) {
    const auto dice = [&](std::int32_t which) { return hash01(i, which, seed + 811); };
    const glm::vec2 middle_px = static_cast<float>(kSide) * glm::vec2(dice(0), dice(1));
    const float half_length_px = 7 + 7 * dice(2), turn_rad = 6.2831853f * dice(3), tone = dice(4);
    for_each_in_leaf(tile, middle_px + 2.0f, 1.15f * half_length_px, turn_rad,
                     [&](std::size_t texel, float, float) { tile.texels[texel + 3] = to_byte(0.55f); });
    for_each_in_leaf(tile, middle_px, half_length_px, turn_rad, [&](std::size_t texel, float u, float v) {
      // Folded along the rib: one half is turned to the light.
      const float shade = 0.5f + (v > 0 ? 0.12f : -0.12f) - (std::abs(v) < 0.12f ? 0.15f : 0.0f) + 0.15f * u * (tone - 0.5f);
      tile.texels[texel] = to_byte(shade + 0.3f * (dice(5) - 0.5f));
      tile.texels[texel + 1] = to_byte(tone);
      tile.texels[texel + 2] = to_byte(static_cast<float>(i + 1) / kLeaves);  // those on top have come first
      tile.texels[texel + 3] = std::byte{255};
    });
  }
  append_mips(tile);
  return tile;
}

std::vector<std::uint16_t> make_height_map(const Terrain& terrain, float extent_m) {
  std::vector<std::uint16_t> heights;
  for (std::uint32_t z = 0; z < kHeightSide_px; ++z)
    for (std::uint32_t x = 0; x < kHeightSide_px; ++x) {
      const glm::vec2 at = (glm::vec2(x, z) + 0.5f) * (2 * extent_m / kHeightSide_px) - extent_m;
      heights.push_back(glm::packHalf1x16(height_at(terrain, at.x, at.y)));
    }
  return heights;
}

Texture make_ground_detail(std::uint32_t seed) {
  constexpr std::int32_t kSide = 512;
  std::vector<float> blades(kSide * kSide);
  const auto at = [](std::int32_t x, std::int32_t z) {
    return static_cast<std::size_t>((z + kSide) % kSide) * kSide + static_cast<std::size_t>((x + kSide) % kSide);
  };
  for (std::int32_t z = 0; z < kSide; ++z)
    for (std::int32_t x = 0; x < kSide; ++x) {
      const float u = static_cast<float>(x) / kSide;
      const float v = static_cast<float>(z) / kSide;
      // Two fields stretched across each other look like blades lying both ways; 32 divides 128, so both repeat.
      const float along = gradient_noise(u * 128, v * 32, seed + 701, 32) * 0.5f + gradient_noise(u * 32, v * 128, seed + 702, 32) * 0.5f;
      const float grain = fractal_noise(u * 48, v * 48, 3, seed + 703, 48);
      blades[at(x, z)] = 0.5f + 0.28f * along + 0.4f * grain;
    }
  Texture texture;
  texture.side_px = kSide;
  for (std::int32_t z = 0; z < kSide; ++z)
    for (std::int32_t x = 0; x < kSide; ++x) {
      const float clumps = fractal_noise(8.0f * static_cast<float>(x) / kSide, 8.0f * static_cast<float>(z) / kSide, 4, seed + 704, 8);
      texture.texels.push_back(to_byte(blades[at(x, z)]));
      texture.texels.push_back(to_byte(0.5f + 0.6f * clumps));
      texture.texels.push_back(to_byte(0.5f + blades[at(x + 1, z)] - blades[at(x - 1, z)]));
      texture.texels.push_back(to_byte(0.5f + blades[at(x, z + 1)] - blades[at(x, z - 1)]));
    }
  append_mips(texture);
  return texture;
}

}  // namespace forest
