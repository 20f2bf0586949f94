#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// How a place of the plant moves, against others of it.
struct WindPoint {
  glm::vec3 position{0.0f};
  float weight = 0.0f;                       ///< how much it counts
  float lean = 0.0f;                         ///< 0..1
  float phase_cos = 1.0f, phase_sin = 0.0f;  ///< of its swing
};

/// What a field is to be, before its limits.
struct WindTarget {
  coppice_file_wind head{};  ///< lean_m and sway_m: what a lean of 1 leans and sways; node_side, all else as it stays
  double radius_m = 0.0;     ///< of the plant's sphere
  bool hangs = false;        ///< the top of the box is still, not the bottom
};

/// The field of these points: each counts at the nodes round it, by how near it is; nodes near none are like those next to them. It is
/// smoothed as long as that lets leaves move further within the limits of format.h, and scaled to keep them.
Wind wind_grid(const std::vector<WindPoint>& points, const WindTarget& target);

}  // namespace coppice::bake
