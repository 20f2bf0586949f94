#pragma once

#include "plant.h"

namespace coppice::bake {

/// The quad about its centroid (the mean of its corners), `factor` times as long; its area grows by factor^2. m
Quad scaled_quad(const Quad& quad, double factor);

}  // namespace coppice::bake
