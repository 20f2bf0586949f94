#pragma once

#include <cstdint>

namespace coppice::bake {

/// Spreads a number's bits over all of them.
inline std::uint64_t mix_bits(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// The generator SplitMix64 (Steele, Lea and Flood 2014). The standard library's distributions differ between implementations; plants and
/// figures must not.
class SeededRandom {
 public:
  explicit SeededRandom(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() { return mix_bits(state_ += 0x9e3779b97f4a7c15ULL); }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Uniform in [0, 1), 24 bits.
  float unit() { return static_cast<float>(next() >> 40) * 0x1p-24f; }
  /// Uniform in [-spread, spread).
  float around(float spread) { return (2.0f * unit() - 1.0f) * spread; }
  /// Uniform in 0 .. count - 1, but for a bias below count / 2^64.
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(next() % count); }
  /// Makes a generator of its own for a part: drawing more numbers from it does not change the parts that follow.
  SeededRandom fork() { return SeededRandom(next()); }

 private:
  std::uint64_t state_;
};

}  // namespace coppice::bake
