#pragma once

// A cloud of voxels with mean opacity and normals: what engines draw of foliage far away (Nanite's voxels, and before them Heitz, Dupuy,
// Crassin, Dachsbacher: The SGGX Microflake Distribution, SIGGRAPH 2015; of Nanite's there is no public description beyond that). Space is
// cut into cubes; one that has leaves in it keeps their area by normal (level.h). Equal bytes: a voxel is counted as 11 (a position of
// three times ten bits, a material, area, and nine shares of normals of four bits), a leaf as 13, what bakes of ten plants took on average.
// The grid is the finest that fits. Swept: how much of the leaves' area counts, since leaves in a cube overlap more or less than leaves
// strewn at random do.

#include <vector>

#include "level.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kVoxelBytes = 11, kLeafBytes = 13;

/// The voxels of `cells` cells along the longest side of the leaves' box, in order of cells. A leaf's area is shared out by 8 x 8 points of
/// its card, those in holes left out. errors  those of alpha_masks
Result<std::vector<Voxel>> fill_voxels(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                       std::uint32_t cells);

/// leaf_counts  each 1 .. leaf_count
/// errors  those of fill_voxels
Result<std::vector<Variant>> voxel_cloud(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                         const std::vector<std::uint32_t>& leaf_counts);

}  // namespace coppice::bake
