#pragma once

#include "plant.h"

namespace coppice::bake {

/// Gives leaves and wood of one material, and pieces of it that differ clearly in colour, materials of their own: bark, needles and baubles
/// of one picture, or of vertex colours. Then each can have the part of the image that it shows (cut_texture_regions), and its mean colour
/// from afar. What belongs together stays together: a leaf, and of the wood triangles that share vertices.
///
/// Nothing is split where the parts would need much more texture than the material did, or beyond kMostParts of a material. Same plant,
/// same result.
/// plant  new materials follow the others; triangle_tints, if any, become base colours and are emptied
void split_materials(Plant& plant);

}  // namespace coppice::bake
