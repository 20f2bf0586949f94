#pragma once

#include <span>

#include <glm/glm.hpp>

#include "ground_map.h"
#include "terrain.h"

namespace forest {

struct Tuft {
  glm::vec3 root;
  float height_m = 0;
  float yaw_rad = 0;
  float tone = 0;               ///< 0 fresh, 1 dry
  float sunlight = 1, sky = 1;  ///< shares that crowns let through
};

constexpr std::uint32_t kTuftVertices = 15;  ///< five blades
constexpr std::size_t kMaxTufts = 8192;

/// The grass tufts near the eye and in view, from a hashed grid of the world: the same place always holds the same tuft.
/// out  [kMaxTufts]. Returns how many were written.
std::size_t gather_tufts(const Terrain& terrain, const GroundMap& map, const glm::mat4& clip_from_world, glm::vec3 eye,
                         std::span<Tuft> out);

}  // namespace forest
