#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

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
};

/// sun_direction  unit, towards the sun: crowns shade the ground away from it
GroundMap make_ground_map(const Planting& planting, const glm::vec3& sun_direction, std::uint32_t seed);
/// A tile that repeats without seams: R fine blades, G clumps, B and A the slope of R along x and z (0.5 is flat).
Texture make_ground_detail(std::uint32_t seed);

}  // namespace forest
