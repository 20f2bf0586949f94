#pragma once

// Tests a ray against the shapes that stand for a plant: its sphere, its box, triangles. Pure functions.

#include <array>
#include <limits>

#include "vectors.h"

namespace coppice {

/// A point of it is origin + t * direction. t is the same in every space that is a scaling (also along single axes), rotation and shift of
/// the world.
struct Ray {
  vec3 origin{0, 0, 0}, direction{0, 0, -1};
};

/// t of a miss.
inline constexpr float kMissed = std::numeric_limits<float>::infinity();

/// Returns t where the ray enters, 0 from inside. direction: unit
float sphere_entry(const Ray& ray, const vec3& center, float radius);
float box_entry(const Ray& ray, const vec3& low, const vec3& high);
/// Hits either side, at t >= 0.
float triangle_hit(const Ray& ray, const std::array<vec3, 3>& triangle);

}  // namespace coppice
