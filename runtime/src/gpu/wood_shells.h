#pragma once

#include <vector>

#include "wood_codec.h"

namespace coppice::gpu {

/// For each triangle which way is out, if its connected surface is closed, as a tube of bark is: 1 along the cross product of its edges
/// (corner 1 - corner 0, corner 2 - corner 0), -1 against it; 0 where the surface is a sheet, which is seen from both sides. Out is where
/// the normals of its vertices point.
std::vector<int> outward_sides(const WoodMesh& mesh);

}  // namespace coppice::gpu
