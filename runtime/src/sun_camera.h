#pragma once

// The camera that a shadow map of the sun is drawn with.

#include "coppice/coppice.h"

namespace coppice {

/// Sets the view's matrices: an orthographic one that looks from the sun, just holding the sphere; depth from three radii before its
/// surface to one behind. The picture's axes depend on the sun alone.
void set_sun_camera(coppice_camera& view, const coppice_sun_desc& desc, bool reversed_depth);

}  // namespace coppice
