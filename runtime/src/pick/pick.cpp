#include "pick.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace coppice {

float sphere_entry(const Ray& ray, const vec3& center, float radius) {
  const vec3 off = center - ray.origin;
  const float along = dot(off, ray.direction);
  // The distance from the line. off^2 - along^2 would lose a near sphere to rounding of a far one.
  const vec3 aside = off - ray.direction * along;
  const float half_chord_2 = radius * radius - dot(aside, aside);
  if (!(half_chord_2 >= 0.0f)) return kMissed;
  const float half_chord = std::sqrt(half_chord_2);
  return along + half_chord < 0.0f ? kMissed : std::max(along - half_chord, 0.0f);
}

float box_entry(const Ray& ray, const vec3& low, const vec3& high) {
  float first = 0.0f, last = kMissed;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (ray.direction[axis] == 0.0f) {
      if (ray.origin[axis] < low[axis] || ray.origin[axis] > high[axis]) return kMissed;
      continue;
    }
    float in = (low[axis] - ray.origin[axis]) / ray.direction[axis], out = (high[axis] - ray.origin[axis]) / ray.direction[axis];
    if (in > out) std::swap(in, out);
    first = std::max(first, in);
    last = std::min(last, out);
  }
  return first <= last ? first : kMissed;
}

// Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).
float triangle_hit(const Ray& ray, const std::array<vec3, 3>& triangle) {
  const vec3 a = triangle[1] - triangle[0], b = triangle[2] - triangle[0];
  const vec3 p = cross(ray.direction, b);
  const float determinant = dot(a, p);
  if (determinant == 0.0f) return kMissed;
  const vec3 from = ray.origin - triangle[0];
  const float u = dot(from, p) / determinant;
  const vec3 q = cross(from, a);
  const float v = dot(ray.direction, q) / determinant;
  const float t = dot(b, q) / determinant;
  return u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t >= 0.0f ? t : kMissed;
}

}  // namespace coppice
