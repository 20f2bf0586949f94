#pragma once

// Places of a large world for the GPU: a cell, and a place in it that floats hold to within 0.02 mm.

#include <algorithm>
#include <cmath>

#include "coppice_shared.h"
#include "vectors.h"

namespace coppice::gpu {

/// A place in a cell of the world.
struct CellPlace {
  ivec3 cell;
  vec3 place;  ///< from the cell's middle, m
};

inline dvec3 world_place(const CellPlace& at) {
  const double side_m = kCellSide_m;
  return {at.cell.x * side_m + double{at.place.x}, at.cell.y * side_m + double{at.place.y}, at.cell.z * side_m + double{at.place.z}};
}

/// Beyond the last cell the place is far from the cell's middle.
inline CellPlace cell_place(const dvec3& place) {
  const auto cell_of = [](double at) {
    return static_cast<int>(std::clamp(std::round(at / double{kCellSide_m}), double{-kMaxCell}, double{kMaxCell}));
  };
  const ivec3 cell{cell_of(place.x), cell_of(place.y), cell_of(place.z)};
  return {cell, (place - world_place({cell, vec3(0.0f)})).rounded()};
}

}  // namespace coppice::gpu
