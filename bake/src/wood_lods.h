#pragma once

#include "plant.h"

namespace coppice::bake {

/// A handful of simplified meshes of the wood, finest first, each about a quarter of the triangles of the one before, down to some tens.
/// Uses meshoptimizer; empty wood gives no LoDs.
WoodLods simplify_wood(const Mesh& wood);

}  // namespace coppice::bake
