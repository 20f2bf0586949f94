#pragma once

#include <span>

#include "plant.h"

namespace coppice::bake {

/// Moves texture coordinates that lie far from 0 near it by whole numbers. Textures repeat, so that all looks the same; but cards and the
/// file hold few places of a texture, for which thousands of repetitions are too many. The vertices of a leaf, and of triangles that share
/// some, move together.
void bring_uvs_near_zero(Mesh& mesh, std::span<const LeafRange> leaves);

}  // namespace coppice::bake
