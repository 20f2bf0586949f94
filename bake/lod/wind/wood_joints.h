#pragma once

#include "plant.h"

namespace coppice::bake {

/// Divides edges of wood that are too long to follow the plant's bending, so that stems curve as what grows on them moves. Edges meet as
/// before. Wood that bends little, or that is modelled finely, stays as it is.
void add_joints(const coppice_file_wind& wind, Mesh& wood);

}  // namespace coppice::bake
