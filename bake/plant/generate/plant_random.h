#pragma once

#include <cstdint>

#include "seeded_random.h"

namespace coppice::bake {

/// The random numbers that a plant grows by.
class PlantRandom {
 public:
  explicit PlantRandom(std::uint64_t seed) : random_(seed) {}

  std::uint64_t bits() { return random_.next(); }

  /// Uniform in [0, 1), 24 bits.
  float unit() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }
  /// Uniform in [-spread, spread).
  float around(float spread) { return (2.0f * unit() - 1.0f) * spread; }
  /// Makes a generator of its own for a part of the plant: drawing more numbers from it does not change the parts that follow.
  PlantRandom fork() { return PlantRandom(bits()); }

 private:
  SeededRandom random_;
};

}  // namespace coppice::bake
