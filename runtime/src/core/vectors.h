#pragma once

// Vectors with GLSL's names for types and functions. The runtime computes with them on the CPU, and headers of shaders/ use them, which
// compile as GLSL too. The types are trivial and laid out as in GLSL's scalar block layout.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>

namespace coppice {

using uint = std::uint32_t;
using std::abs, std::ceil, std::clamp, std::cos, std::exp, std::exp2, std::floor, std::log2, std::max, std::min, std::round, std::sin,
    std::sqrt;

inline float uintBitsToFloat(uint bits) {
  return std::bit_cast<float>(bits);
}
inline float inversesqrt(float x) {
  return 1.0f / std::sqrt(x);
}

/// Packs values of low to 1 side by side into a word, each as a whole number of `steps` to 1, the first one lowest.
inline uint packed_steps(std::initializer_list<float> values, float low, float steps) {
  const std::size_t bits = 32 / values.size();
  uint word = 0;
  for (const float* value = values.end(); value != values.begin();) {
    const auto step = static_cast<uint>(std::lround(clamp(*--value, low, 1.0f) * steps));
    word = word << bits | (step & ((1u << bits) - 1u));
  }
  return word;
}

struct vec2 {
  float x, y;

  vec2() = default;
  constexpr vec2(float first, float second) : x(first), y(second) {}
  friend uint packSnorm2x16(const vec2& v) { return packed_steps({v.x, v.y}, -1.0f, 32767.0f); }
};

/// Converts a number to a half and back. Values beyond the largest half become that; values below 2^-14 become 0.
inline uint half_of(float x) {
  constexpr float kMaximum = 65504.0f, kMinimum = 1.0f / 16384.0f;
  const float size = std::min(std::fabs(x), kMaximum);
  if (!(size >= kMinimum)) return 0;
  const uint bits = std::bit_cast<uint>(size) + 0xfffu + (std::bit_cast<uint>(size) >> 13u & 1u);
  return (x < 0.0f ? 0x8000u : 0u) | std::min((bits >> 13u) - (112u << 10u), 0x7bffu);
}
inline float of_half(uint half) {
  const uint size = half & 0x7fffu;
  const float x = size == 0 ? 0.0f : std::bit_cast<float>((size + (112u << 10u)) << 13u);
  return (half & 0x8000u) != 0 ? -x : x;
}
inline uint packHalf2x16(const vec2& v) {
  return half_of(v.x) | half_of(v.y) << 16u;
}
inline vec2 unpackHalf2x16(uint word) {
  return {of_half(word & 0xffffu), of_half(word >> 16u)};
}

struct uvec2 {
  uint x, y;
};

struct uvec3 {
  uint x, y, z;

  uvec3() = default;
  constexpr uvec3(uint first, uint second, uint third) : x(first), y(second), z(third) {}
  constexpr uint operator[](std::size_t axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

struct vec3 {
  float x, y, z;

  vec3() = default;
  constexpr explicit vec3(float all) : x(all), y(all), z(all) {}
  constexpr vec3(float first, float second, float third) : x(first), y(second), z(third) {}
  constexpr explicit vec3(const uvec3& v) : x(float(v.x)), y(float(v.y)), z(float(v.z)) {}
  constexpr explicit vec3(std::span<const float, 3> v) : x(v[0]), y(v[1]), z(v[2]) {}
  constexpr float& operator[](std::size_t axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr float operator[](std::size_t axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  friend bool operator==(const vec3&, const vec3&) = default;

  friend vec3 operator+(const vec3& a, const vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend vec3 operator-(const vec3& a, const vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend vec3 operator*(const vec3& a, const vec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend vec3 operator/(const vec3& a, const vec3& b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
  friend vec3 operator*(const vec3& a, float factor) { return {a.x * factor, a.y * factor, a.z * factor}; }
  friend vec3 operator*(float factor, const vec3& a) { return a * factor; }
  vec3& operator+=(const vec3& b) { return *this = *this + b; }

  friend vec3 min(const vec3& a, const vec3& b) { return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)}; }
  friend vec3 max(const vec3& a, const vec3& b) { return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)}; }
  friend vec3 clamp(const vec3& a, const vec3& low, const vec3& high) { return min(max(low, a), high); }  // low if a is NaN
  friend vec3 abs(const vec3& a) { return {abs(a.x), abs(a.y), abs(a.z)}; }
  friend vec3 floor(const vec3& a) { return {floor(a.x), floor(a.y), floor(a.z)}; }
  friend vec3 round(const vec3& a) { return {round(a.x), round(a.y), round(a.z)}; }
  friend vec3 sqrt(const vec3& a) { return {sqrt(a.x), sqrt(a.y), sqrt(a.z)}; }
  friend float dot(const vec3& a, const vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  friend vec3 cross(const vec3& a, const vec3& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
  friend float length(const vec3& a) { return sqrt(dot(a, a)); }
  friend float distance(const vec3& a, const vec3& b) { return length(a - b); }
  friend vec3 normalize(const vec3& a) { return a * inversesqrt(dot(a, a)); }
};

struct ivec3 {
  int x, y, z;

  ivec3() = default;
  constexpr ivec3(int first, int second, int third) : x(first), y(second), z(third) {}
};

/// Positions in a large world; differences of near ones are vec3.
struct dvec3 {
  double x, y, z;

  dvec3() = default;
  constexpr dvec3(double first, double second, double third) : x(first), y(second), z(third) {}
  constexpr explicit dvec3(const vec3& v) : x(v.x), y(v.y), z(v.z) {}
  constexpr explicit dvec3(std::span<const double, 3> v) : x(v[0]), y(v[1]), z(v[2]) {}
  constexpr double operator[](std::size_t axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  [[nodiscard]] constexpr vec3 rounded() const { return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)}; }
  friend bool operator==(const dvec3&, const dvec3&) = default;

  friend dvec3 operator+(const dvec3& a, const dvec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend dvec3 operator-(const dvec3& a, const dvec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend dvec3 operator*(const dvec3& a, double factor) { return {a.x * factor, a.y * factor, a.z * factor}; }
  friend double dot(const dvec3& a, const dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  friend dvec3 cross(const dvec3& a, const dvec3& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
  friend dvec3 min(const dvec3& a, const dvec3& b) { return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)}; }
  friend dvec3 max(const dvec3& a, const dvec3& b) { return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)}; }
};

struct vec4 {
  float x, y, z, w;

  vec4() = default;
  constexpr vec4(float first, float second, float third, float fourth) : x(first), y(second), z(third), w(fourth) {}
  constexpr vec4(const vec3& v, float last) : x(v.x), y(v.y), z(v.z), w(last) {}
  [[nodiscard]] constexpr vec3 xyz() const { return {x, y, z}; }
  friend bool operator==(const vec4&, const vec4&) = default;
  friend vec4 operator+(const vec4& a, const vec4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
  friend vec4 operator-(const vec4& a, const vec4& b) { return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w}; }
  friend vec4 operator*(const vec4& a, float factor) { return {a.x * factor, a.y * factor, a.z * factor, a.w * factor}; }
  friend uint packSnorm4x8(const vec4& v) { return packed_steps({v.x, v.y, v.z, v.w}, -1.0f, 127.0f); }
  friend uint packUnorm4x8(const vec4& v) { return packed_steps({v.x, v.y, v.z, v.w}, 0.0f, 255.0f); }
};

struct mat4 {
  vec4 column[4];

  mat4() = default;
  explicit mat4(std::span<const float, 16> m) {
    for (std::size_t i = 0; i < 4; ++i) column[i] = {m[4 * i], m[4 * i + 1], m[4 * i + 2], m[4 * i + 3]};
  }
  friend vec4 operator*(const mat4& m, const vec4& v) {
    return m.column[0] * v.x + m.column[1] * v.y + m.column[2] * v.z + m.column[3] * v.w;
  }
  friend mat4 operator*(const mat4& a, const mat4& b) {
    mat4 product;
    for (std::size_t i = 0; i < 4; ++i) product.column[i] = a * b.column[i];
    return product;
  }
  friend mat4 transpose(const mat4& m) {
    const vec4 &a = m.column[0], &b = m.column[1], &c = m.column[2], &d = m.column[3];
    mat4 rows;
    rows.column[0] = {a.x, b.x, c.x, d.x};
    rows.column[1] = {a.y, b.y, c.y, d.y};
    rows.column[2] = {a.z, b.z, c.z, d.z};
    rows.column[3] = {a.w, b.w, c.w, d.w};
    return rows;
  }
};

}  // namespace coppice
