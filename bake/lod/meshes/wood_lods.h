#pragma once

#include "plant.h"

namespace coppice::bake {

/// Meshes of one LoD with about the same number of triangles; the finest level has one mesh, all of the wood. In the first, small pieces
/// that get no triangles give their area to neighbours, so that a bare wood stays as dense as it is. In the second they are left out, which
/// is nearer to the image if a crown hides them. If trunk and boughs are one surface, two more are made of its limbs in the same ways.
using WoodLevel = std::vector<Mesh>;
/// Meshes of a level that are not made of limbs come first: at most so many.
inline constexpr std::size_t kWholeMeshes = 2;

/// Makes up to seven levels of the wood, finest first: all of its triangles, then each about a quarter of the one before, down to some tens
/// if the wood allows. The weightiest piece of each material is in every mesh. Triangles are sorted by material and, within one, for the
/// GPU's vertex cache. Empty wood has no levels. Same wood, same levels.
std::vector<WoodLevel> wood_levels(const Mesh& wood);

/// Reduces wood to at most half its triangles, but at least one of each material: clusters vertices, whatever becomes of the shape. For
/// wood that wood_levels cannot make small enough.
Mesh halve_wood(const Mesh& wood);

}  // namespace coppice::bake
