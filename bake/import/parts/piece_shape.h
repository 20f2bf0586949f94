#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "plant.h"

namespace coppice::bake {

/// The form of a piece of surface, whatever its place and direction.
struct PieceShape {
  std::uint32_t point_count = 0;     ///< distinct positions
  double length_m = 0.0;             ///< between two points about as far apart as any
  double width_m = 0.0;              ///< twice the largest distance of a point from the line between those two points
  double area_m2 = 0.0;              ///< all triangles; a closed piece counts both sides
  double low_m = 0.0, high_m = 0.0;  ///< heights of the lowest and the highest point
  /// How much the surface is a sheet, [1/3, 1]; 0 without area. The largest of three measures, with n the unit normals:
  /// 1. The largest eigenvalue of the mean of n n^T over the surface, whichever side is out: a card 1, a closed lens above 0.8, a tube or
  /// two crossed cards 1/2, a ball 1/3.
  /// 2. The length of the mean of n: a leaf folded by a right angle 0.7, a tube 0.
  /// 3. 0.8 if its rim is as long as that of a flat sheet of its area, however it is curled or twisted; half a ball, tubes, rings and
  /// closed surfaces 0.
  double flatness = 0.0;
  /// How much a closed piece is a body, [0, 1]: 36 pi volume^2 / area^3. A ball 1, a cube 0.52, a cone as high as wide 0.47, a leaf a third
  /// as thick as wide below 0.1, a closed lens 0.01. An open piece has 0, unless the square of its rim is less than 3 pi of the area: half
  /// a ball counts as closed.
  double bulk = 0.0;

  [[nodiscard]] double elongation() const { return length_m / std::max(width_m, 1e-3 * length_m); }
  [[nodiscard]] double slenderness() const { return length_m * length_m / area_m2; }
};

/// Maximum flatness of a tube.
inline constexpr double kTubeFlatness = 0.65;

/// mesh       welded positions must be equal
/// triangles  numbers of the piece's triangles, at least one
PieceShape measure_piece(const Mesh& mesh, std::span<const std::uint32_t> triangles);

}  // namespace coppice::bake
