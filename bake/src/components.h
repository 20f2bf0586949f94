#pragma once

#include <cstdint>
#include <vector>

#include "gltf_triangles.h"
#include "plant.h"

namespace coppice::bake {

/// Foliage triangles sorted by leaf.
struct SplitFoliage {
  Mesh mesh;
  std::vector<LeafRange> leaves;  ///< ordered by their first triangle in the soup; tile the mesh's triangles
  std::uint32_t dropped_leaf_count = 0;
};

/// Splits foliage into leaves: components connected through welded positions (weld.h), each within one mesh instance. Positions that were
/// welded become equal. Triangles with two corners in one place connect nothing and are dropped; leaves without area are dropped and
/// counted.
SplitFoliage split_leaves(TriangleSoup soup);

}  // namespace coppice::bake
