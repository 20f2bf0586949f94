#pragma once

// A cloud of voxels with mean opacity and normals, as engines draw far foliage (Nanite's voxels, of which no more is public, and before
// them Heitz, Dupuy, Crassin, Dachsbacher: The SGGX Microflake Distribution, SIGGRAPH 2015). Space is cut into cubes; one that has leaves
// in it keeps their area by normal (level.h). Methods are compared at equal bytes. A voxel counts as 11: a position of three times ten
// bits, a material, area, and nine shares of normals of four bits. A leaf counts as 13, the mean of the bakes of ten plants. The grid is
// the finest that fits. Swept is how much of the leaves' area counts, since leaves in a cube overlap more or less than leaves that are
// strewn at random.

#include <vector>

#include "level.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kVoxelBytes = 11, kLeafBytes = 13;

/// Fills a grid with `cells` cells along the longest side of the leaves' box; voxels are in the order of cells. A leaf's area is
/// distributed over 8 x 8 points of its card, without those in holes.
/// errors  those of alpha_masks
Result<std::vector<Voxel>> fill_voxels(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                       std::uint32_t cells);

/// leaf_counts  each 1 .. leaf_count
/// errors  those of fill_voxels
Result<std::vector<Variant>> voxel_cloud(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                         const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
