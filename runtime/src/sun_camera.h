#pragma once

// The camera of the sun's shadow map.

#include "coppice/coppice.h"

namespace coppice {

/// Sets the view's matrices: an orthographic view from the sun that just holds the sphere, with depth from three radii before its surface
/// to one behind. The picture's axes depend on the sun alone.
void set_sun_camera(coppice_camera& view, const coppice_sun_desc& desc, bool reversed_depth);

}  // namespace coppice
