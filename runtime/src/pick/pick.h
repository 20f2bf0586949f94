#pragma once

// A ray against what stands for a plant: its sphere, its box, triangles. Pure functions.

#include <array>
#include <limits>

#include "vectors.h"

namespace coppice {

/// A place of it is origin + t * direction. In any space that is a scaling, a turning and a shift of the world, along each axis for itself
/// if need be: t is the same in all of them.
struct Ray {
  vec3 origin{0, 0, 0}, direction{0, 0, -1};
};

/// t of what is not hit.
inline constexpr float kMissed = std::numeric_limits<float>::infinity();

/// Where the ray comes in, 0 from within. direction: unit
float sphere_entry(const Ray& ray, const vec3& center, float radius);
float box_entry(const Ray& ray, const vec3& low, const vec3& high);
/// From either side, t >= 0.
float triangle_hit(const Ray& ray, const std::array<vec3, 3>& triangle);

}  // namespace coppice
