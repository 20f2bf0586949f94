#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "feet.h"
#include "placement.h"

namespace forest {

/// 8-bit RGBA with all its mips, level 0 first, tightly packed.
struct Texture {
  std::uint32_t side_px = 0;
  std::uint32_t mip_count = 1;
  std::vector<std::byte> texels;
};

/// What the planting does to the ground, one texel a patch of the square [-extent_m, extent_m]^2:
/// R sunlight that crowns let through, G share of trodden earth, B sky seen between crowns, A how lush the grass is.
struct GroundMap {
  float extent_m = 0;
  bool among_others = false;  ///< what is planted is part of a forest
  Texture texture;
  Feet feet;
};

/// sun_direction  unit, towards the sun: crowns shade the ground away from it
GroundMap make_ground_map(const Planting& planting, const glm::vec3& sun_direction, std::uint32_t seed);
/// Fallen leaves, a tile that repeats: R how bright, G which of them, B how soon a leaf lies there as litter gets more (0: none does), A
/// the light between leaves.
Texture make_litter(std::uint32_t seed);
/// Height of the ground, half floats, [kHeightSide_px^2] over the ground map's square.
std::vector<std::uint16_t> make_height_map(const Terrain& terrain, float extent_m);
constexpr std::uint32_t kHeightSide_px = 512;
/// A tile that repeats without seams: R fine blades, G clumps, B and A the slope of R along x and z (0.5 is flat).
Texture make_ground_detail(std::uint32_t seed);

}  // namespace forest
