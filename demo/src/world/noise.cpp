#include "noise.h"

#include <array>
#include <cmath>

namespace forest {
namespace {

float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

std::int32_t wrap(std::int32_t cell, std::int32_t period) {
  return period > 0 ? ((cell % period) + period) % period : cell;
}

// Slope of the lattice point's gradient towards (dx, dz).
float slope(std::int32_t x, std::int32_t z, std::uint32_t seed, float dx, float dz) {
  constexpr float kHalf = 0.70710678f;
  constexpr std::array<std::array<float, 2>, 8> kGradients = {
      {{1, 0}, {kHalf, kHalf}, {0, 1}, {-kHalf, kHalf}, {-1, 0}, {-kHalf, -kHalf}, {0, -1}, {kHalf, -kHalf}}};
  const auto& gradient = kGradients[hash(x, z, seed) >> 29];
  return gradient[0] * dx + gradient[1] * dz;
}

}  // namespace

std::uint32_t hash(std::int32_t x, std::int32_t z, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9e3779b1u ^ (static_cast<std::uint32_t>(z) * 0x85ebca77u + seed * 0xc2b2ae3du);
  h = (h ^ h >> 16) * 0x7feb352du;
  h = (h ^ h >> 15) * 0x846ca68bu;
  return h ^ h >> 16;
}

float hash01(std::int32_t x, std::int32_t z, std::uint32_t seed) {
  return static_cast<float>(hash(x, z, seed) >> 8) * 0x1p-24f;
}

float gradient_noise(float x, float z, std::uint32_t seed, std::int32_t period) {
  const float floor_x = std::floor(x);
  const float floor_z = std::floor(z);
  const float dx = x - floor_x;
  const float dz = z - floor_z;
  const std::int32_t x0 = wrap(static_cast<std::int32_t>(floor_x), period);
  const std::int32_t z0 = wrap(static_cast<std::int32_t>(floor_z), period);
  const std::int32_t x1 = wrap(x0 + 1, period);
  const std::int32_t z1 = wrap(z0 + 1, period);
  const float u = fade(dx);
  const float v = fade(dz);
  const float near_row = std::lerp(slope(x0, z0, seed, dx, dz), slope(x1, z0, seed, dx - 1, dz), u);
  const float far_row = std::lerp(slope(x0, z1, seed, dx, dz - 1), slope(x1, z1, seed, dx - 1, dz - 1), u);
  return 1.5f * std::lerp(near_row, far_row, v);
}

float fractal_noise(float x, float z, int octaves, std::uint32_t seed, std::int32_t period) {
  float sum = 0;
  float weight = 1;
  float total = 0;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += weight * gradient_noise(x, z, seed + static_cast<std::uint32_t>(octave), period);
    total += weight;
    weight *= 0.5f;
    x *= 2;
    z *= 2;
    period *= 2;
  }
  return sum / total;
}

}  // namespace forest
