#pragma once

// Three floats as a point or a direction, in one place for what the runtime builds on the CPU.

#include <array>
#include <cmath>

namespace coppice::gpu {

using Point = std::array<float, 3>;

inline Point operator-(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Point operator*(const Point& a, float factor) {
  return {a[0] * factor, a[1] * factor, a[2] * factor};
}
inline Point operator+(const Point& a, const Point& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline float dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline float length(const Point& a) {
  return std::sqrt(dot(a, a));
}
/// Of a quad's two triangles, (0, 1, 2) and (0, 2, 3).
inline float quad_area(const std::array<Point, 4>& c) {
  const Point across = c[2] - c[0];
  return 0.5f * (length(cross(c[1] - c[0], across)) + length(cross(across, c[3] - c[0])));
}
inline Point normalised(const Point& a) {
  return a * (1.0f / length(a));
}

}  // namespace coppice::gpu
