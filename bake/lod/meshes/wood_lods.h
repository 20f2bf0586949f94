#pragma once

#include <vector>

#include "plant.h"

namespace coppice::bake {

/// Two ways to spend a LoD's triangles; the finest has one mesh, all of the wood. In the first, small pieces that there are no triangles
/// for give their area to others near them, so that a bare wood stays as dense as it is; in the second they are left out, which is nearer
/// to the picture where a crown hides them.
using WoodLevel = std::vector<Mesh>;

/// Up to seven levels of the wood, finest first: all of its triangles, then each about a quarter of the one before, down to some tens where
/// the wood allows. The weightiest piece of each material is in every mesh. Triangles are sorted by material and, within one, for the
/// GPU's vertex cache. Empty wood gives none. Same wood, same levels.
std::vector<WoodLevel> wood_levels(const Mesh& wood);

/// The same wood in at most half the triangles, but at least one of each material: vertices are clustered, whatever becomes of the shape.
/// For wood that wood_levels cannot make as small as it must be.
Mesh halve_wood(const Mesh& wood);

}  // namespace coppice::bake
