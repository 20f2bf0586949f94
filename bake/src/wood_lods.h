#pragma once

#include "plant.h"

namespace coppice::bake {

/// Up to seven meshes of the wood, finest first: all of its triangles, then each about a quarter of the one before, down to some tens where
/// the wood allows. Coarse LoDs leave out the thinnest connected pieces (twigs) and simplify the others with meshoptimizer; the weightiest
/// piece of each material is in every LoD. Triangles are sorted by material and, within one, for the GPU's vertex cache; vertices are
/// those of the source. Empty wood gives no LoDs. Same wood, same LoDs.
WoodLods simplify_wood(const Mesh& wood);

/// The same wood in at most half the triangles, but at least one of each material: vertices are clustered, whatever becomes of the shape.
/// For wood that simplify_wood cannot make as small as it must be.
Mesh halve_wood(const Mesh& wood);

}  // namespace coppice::bake
