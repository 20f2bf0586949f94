#pragma once

#include "plant.h"

namespace coppice::bake {

/// Bounds of leaf quads: sphere about the box centre. Radius 0 when every vertex is the same point, or there is none.
Sphere bounding_sphere(const Foliage& foliage);

/// Bounds of a plant: sphere about the centre of the box of leaf quads, wood and leaf meshes.
Sphere plant_sphere(const Foliage& foliage, const Mesh& wood, const LeafMeshes& leaf_meshes = {});

}  // namespace coppice::bake
