#pragma once

// The cost of a merge for every opacity and brightness that its leaf may have.
//
// In each pixel and block the image is linear in the opacity of one leaf, and in its opacity times its brightness. The error is therefore a
// quadratic form of these two.

#include <cstdint>

namespace coppice::bake {

/// What a merge adds to the error if the merged leaf has opacity o and emits light s, which is o times its brightness:
/// constant + opacity o + light s + opacity2 o^2 + both o s + light2 s^2.
struct MergeCost {
  double constant = 0.0, opacity = 0.0, light = 0.0, opacity2 = 0.0, both = 0.0, light2 = 0.0;
  [[nodiscard]] double at(std::uint8_t fade) const;
  /// Whether any view shows the merged leaf.
  [[nodiscard]] bool is_seen() const { return opacity2 > 0.0; }
  /// The cheapest fade among those no brighter than `brightest`; of equals the one with the smallest opacity. is_seen() must hold.
  [[nodiscard]] std::uint8_t best_fade(std::uint8_t brightest) const;

  MergeCost& operator+=(const MergeCost& other) {
    constant += other.constant;
    opacity += other.opacity, light += other.light;
    opacity2 += other.opacity2, both += other.both, light2 += other.light2;
    return *this;
  }
  [[nodiscard]] MergeCost operator*(double weight) const {
    return {constant * weight, opacity * weight, light * weight, opacity2 * weight, both * weight, light2 * weight};
  }
};

}  // namespace coppice::bake
