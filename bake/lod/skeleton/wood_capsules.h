#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"

namespace coppice::bake {

/// All points within radius_m of a line.
struct Capsule {
  glm::dvec3 from{0.0}, to{0.0};  ///< object space, m
  double radius_m = 0.0;
};

/// Approximates a plant's stem and boughs by capsules, for colliders and navigation meshes. Each follows a part of a limb (wood_limbs),
/// with the mean radius of the wood there. The next capsule is the one that adds or corrects most wood: the first is the stem. Limbs
/// thinner than a tenth of the thickest wood have none. max_count  > 0 returns    none without wood
std::vector<Capsule> wood_capsules(const Mesh& wood, std::uint32_t max_count);

}  // namespace coppice::bake
