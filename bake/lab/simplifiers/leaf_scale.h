#pragma once

#include "plant.h"

namespace coppice::bake {

/// Scales the quad about its centroid (the mean of its corners), so that its area grows by factor^2.
Quad scaled_quad(const Quad& quad, double factor);

}  // namespace coppice::bake
