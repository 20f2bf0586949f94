#pragma once

#include "plant.h"

namespace coppice::bake {

/// Bounding sphere of leaf quads, about the centre of their box. Its radius is 0 if all vertices are one point, or if there are none.
Sphere bounding_sphere(const Foliage& foliage);

/// Bounding sphere of a plant, about the centre of the box of leaf quads, wood and leaf meshes.
Sphere plant_sphere(const Foliage& foliage, const Mesh& wood, const LeafMeshes& leaf_meshes = {});

}  // namespace coppice::bake
