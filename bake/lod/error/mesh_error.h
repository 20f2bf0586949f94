#pragma once

#include <span>
#include <vector>

#include "plant.h"
#include "result.h"
#include "wood_lods.h"

namespace coppice::bake {

/// Error of all quads against the leaf meshes, px, at the table's sizes: the same views, light and unit, but both in the colours that their
/// images show there, from the mip level whose texels are about a pixel. Made not falling by a running maximum from the smallest size up.
/// plant   tree, card_table, materials, images, leaf_meshes (with parts) and sphere are read
/// errors  invalid_argument: a material names an image that is not there
Result<std::vector<float>> measure_leaf_mesh_error(const BakedPlant& plant);

/// Error of each wood LoD against the finest, px, [lods * sizes], row per LoD: as above, but lit by the normals of its vertices, as it is
/// drawn, in front of and behind all leaf quads, so that what the crown hides does not count; or what the LoD changes of the plant, where
/// that is more: 1.5 times the size, up to 64 px, times the share of the plant's picture, leaves and wood, that is lost or too much in
/// 8 x 8 parts of it. Squares hardly see that a thin stem is missing, as it is a small share of each of its pixels. Made not falling from
/// one LoD to the next by a running maximum.
/// plant   tree, card_table, materials, images, sphere and the sizes of its error table are read
/// lods    finest first
/// errors  invalid_argument: a material names an image that is not there, or the table has other sizes than kErrorSizesPx
Result<std::vector<float>> measure_wood_error(const BakedPlant& plant, std::span<const Mesh* const> lods);

/// Of each level of wood the mesh whose picture is nearest to the finest's among all leaf quads, by the errors above, and those errors.
/// levels  of wood_levels; errors  as above
Result<WoodLods> choose_wood_lods(const BakedPlant& plant, std::vector<WoodLevel> levels);

}  // namespace coppice::bake
