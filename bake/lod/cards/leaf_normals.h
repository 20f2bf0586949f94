#pragma once

#include "plant.h"

namespace coppice::bake {

/// Sets Material::sided_normals where an artist gave leaves other normals than their faces have: grass that of the ground, crowns those of
/// a dome. Such normals stay on their side, whoever looks; others are on the side that the eye sees. Adds a warning for each such material.
void find_sided_normals(Plant& plant);

/// Turns the leaves' normals to those of the crown's round shape, an ellipsoid in the leaves' box, and gives them a side.
/// share  0: not at all; 1: the shape's normals alone
void turn_normals_to_crown(Plant& plant, float share);

/// Fills in normals and normal_sums: those of the leaves as they were modelled if they are bent or have sides. A leaf that is about flat
/// has those of its quad, kFlatNormals, which cost no bytes.
void add_leaf_normals(const Plant& plant, Foliage& foliage);

}  // namespace coppice::bake
