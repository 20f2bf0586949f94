#pragma once

// The cost of a merge for every opacity that its leaf may have.
//
// In each pixel and block the image is linear in the opacity of one leaf. The error is therefore a parabola.

#include <cstdint>

namespace coppice::bake {

/// What a merge adds to the error if the merged leaf has opacity o: constant + opacity o + opacity2 o^2.
struct MergeCost {
  double constant = 0.0, opacity = 0.0, opacity2 = 0.0;
  /// opacity_steps  core/tree.h
  [[nodiscard]] double at(std::uint8_t opacity_steps) const;
  /// Whether any view shows the merged leaf.
  [[nodiscard]] bool is_seen() const { return opacity2 > 0.0; }
  /// The cheapest opacity; of equals the smallest. is_seen() must hold.
  [[nodiscard]] std::uint8_t best_opacity() const;

  MergeCost& operator+=(const MergeCost& other) {
    constant += other.constant, opacity += other.opacity, opacity2 += other.opacity2;
    return *this;
  }
  [[nodiscard]] MergeCost operator*(double weight) const { return {constant * weight, opacity * weight, opacity2 * weight}; }
};

}  // namespace coppice::bake
