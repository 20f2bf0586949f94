#pragma once

#include <cstdint>

namespace coppice::bake {

/// SplitMix64 (Steele, Lea and Flood 2014): the same numbers on every compiler, which the standard library's distributions do not promise.
class PlantRandom {
 public:
  explicit PlantRandom(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  /// Uniform in [0, 1), 24 bits.
  float unit() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }
  /// Uniform in [-spread, spread).
  float around(float spread) { return (2.0f * unit() - 1.0f) * spread; }
  /// A value of its own for a part of the plant: drawing more numbers there does not change the parts that follow.
  PlantRandom fork() { return PlantRandom(bits()); }

 private:
  std::uint64_t state_;
};

}  // namespace coppice::bake
