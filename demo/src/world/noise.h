#pragma once

#include <cstdint>

namespace forest {

/// A well-mixed hash of a lattice point; the same on every machine.
std::uint32_t hash(std::int32_t x, std::int32_t z, std::uint32_t seed);
/// hash as a number in [0, 1).
float hash01(std::int32_t x, std::int32_t z, std::uint32_t seed);
/// Gradient noise in about [-1, 1] on a unit lattice. period > 0 makes it repeat after that many cells.
float gradient_noise(float x, float z, std::uint32_t seed, std::int32_t period = 0);
/// `octaves` of gradient noise, each of twice the frequency and half the weight, normalised to about [-1, 1].
float fractal_noise(float x, float z, int octaves, std::uint32_t seed, std::int32_t period = 0);

}  // namespace forest
