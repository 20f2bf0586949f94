#pragma once

#include "plant.h"

namespace coppice::bake {

/// How a place of the plant moves relative to others.
struct WindPoint {
  glm::vec3 position{0.0f};
  float weight = 0.0f;                       ///< how much it counts
  float lean = 0.0f;                         ///< 0..1
  float phase_cos = 1.0f, phase_sin = 0.0f;  ///< the phase of its swing
};

/// The properties of a field before its limits apply.
struct WindTarget {
  coppice_file_wind head{};  ///< lean_m and sway_m: how far a lean of 1 leans and sways; node_side; the rest stays
  double radius_m = 0.0;     ///< the plant's sphere's
  bool hangs = false;        ///< the top of the box is still, not the bottom
};

/// Makes a field from points. Each point counts at the nodes round it, by its distance; nodes without near points follow their neighbours.
/// The field is smoothed as long as that lets leaves move farther within the limits of format.h, and scaled to keep these limits.
Wind wind_grid(const std::vector<WindPoint>& points, const WindTarget& target);

}  // namespace coppice::bake
