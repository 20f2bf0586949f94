#pragma once

#include "plant.h"
#include "result.h"
#include "wood_lods.h"

namespace coppice::bake {

/// Error of all quads against the leaf meshes, px, at the table's sizes, with the same views, light and unit. Both are drawn in the colours
/// of their images, from the mip level whose texels are about a pixel. Where coverage_error_px of the share by which coverage differs is
/// larger, that. A running maximum from the smallest size up makes it non-decreasing.
/// plant   tree, card_table, materials, images, leaf_meshes (with parts) and sphere are read
/// errors  invalid_argument: a material names an image that is not there
Result<std::vector<float>> measure_leaf_mesh_error(const BakedPlant& plant);

/// Error of each wood LoD against the finest, px, [lods * sizes], row per LoD. It is the largest of four errors:
/// - as above, but lit by the normals of the wood's vertices, and drawn among all leaf quads, so that what the crown hides does not count;
/// - 96 / 36 times the size, up to 36 px, times the share of the image of leaves and wood that is lost or too much in 8 x 8 parts of it;
/// - 20 times the share of the wood in front of or beside leaves whose stems are lost or too thick, where they are about a pixel wide;
/// - coverage_error_px of the share by which the coverage of leaves and wood differs in the view where it differs most.
/// Squares hardly show that a thin stem is missing, since it is a small share of each of its pixels, and it holds up the tree.
/// A running maximum from one LoD to the next makes it non-decreasing.
/// plant   tree, card_table, materials, images, sphere and the sizes of its error table are read
/// lods    finest first
/// errors  invalid_argument: a material names an image that is not there, or the table has other sizes than kErrorSizesPx
Result<std::vector<float>> measure_wood_error(const BakedPlant& plant, std::span<const Mesh* const> lods);

/// Chooses for each level of wood the mesh whose image, among all leaf quads, is nearest to the finest's by these errors, and returns it
/// with its errors. The errors of meshes of limbs count one and a half times.
/// levels  from wood_levels
/// errors  as above
Result<WoodLods> choose_wood_lods(const BakedPlant& plant, std::vector<WoodLevel> levels);

}  // namespace coppice::bake
