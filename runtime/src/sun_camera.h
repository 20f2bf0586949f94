#pragma once

// The camera that a shadow map of the sun is drawn with.

#include "coppice/coppice.h"
#include "vectors.h"

namespace coppice {

struct SunSphere {
  vec3 center{};  ///< world space, m
  float radius_m = 1;
};

/// Sets the view's matrices: from 40 radii towards the view's sun, just holding the sphere; depth from three radii before its surface to
/// one behind. The picture's axes depend on the sun alone.
void set_sun_camera(coppice_view& view, const SunSphere& sphere, bool reversed_depth);

}  // namespace coppice
