#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plant.h"

namespace coppice::bake {

/// The corners of triangles as points: welded positions, separate for each material.
class Points {
 public:
  Points(const Mesh& mesh, const std::vector<std::uint32_t>& welded);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::array<std::uint32_t, 3> of(std::size_t triangle) const {
    return {corners_[3 * triangle], corners_[3 * triangle + 1], corners_[3 * triangle + 2]};
  }
  [[nodiscard]] bool is_collapsed(std::size_t triangle) const {
    const auto [a, b, c] = of(triangle);
    return a == b || b == c || c == a;
  }
  /// Whether the triangle has an area. False also if its corners are in a line, or nearer to one than the weld tolerance: such triangles
  /// fill T-junctions.
  [[nodiscard]] bool has_area(std::size_t triangle) const { return has_area_[triangle]; }

 private:
  std::vector<std::uint32_t> corners_;
  std::size_t count_;
  std::vector<bool> has_area_;
};

}  // namespace coppice::bake
