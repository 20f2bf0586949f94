#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "trail.h"

namespace forest {

/// What placement must know of a plant, in its own units.
struct Species {
  float radius_m = 1;                                         ///< radius of the bounding sphere
  float foot_m = 0;                                           ///< height, in object space, of what stands on the ground
  glm::vec3 box_min = glm::vec3(-1), box_max = glm::vec3(1);  ///< bounds of what is drawn
};

struct PlacedPlant {
  std::uint32_t species = 0;
  glm::vec2 position = glm::vec2(0);  ///< plan (x, z), metres
  float scale = 1;
  float yaw_rad = 0;
  bool mirrored = false;        ///< left and right, before it is turned
  glm::vec2 lean_rad = {0, 0};  ///< out of the vertical, towards x and z
  float slope_share = 0;        ///< share of the ground's slope by which it leans downhill
  float crown_radius_m = 1;     ///< radius of the scaled plant in plan
  glm::vec3 tint = glm::vec3(1);
};

struct Planting {
  float half_extent_m = 0;  ///< the plants stand in a square of twice this side round the origin
  Trail trail;
  std::vector<PlacedPlant> plants;  ///< exactly the count asked for
};

/// What the forest multiplies the size of a plant with whose bounding sphere has this radius: a plant of a hand's or a cathedral's size is
/// brought into a forest's range; within it the file's metres are kept.
float fitting_scale(float radius_m);

/// Plants `count` instances: groves and clearings from noise, no two closer than their crowns allow, none on the trail.
/// The square grows until they fit. One plant stands in the middle, unturned and untinted. Same arguments, same planting.
/// species  not empty
Planting plant_forest(std::span<const Species> species, std::uint32_t count, std::uint32_t seed);

}  // namespace forest
