#pragma once

#include "plant.h"

namespace coppice::bake {

/// Gives leaves and wood of one material, and pieces of it that differ clearly in colour, materials of their own: bark, needles and baubles
/// that share an image, or vertex colours. Then each can have the part of the image that it shows (cut_texture_regions), and its mean
/// colour from afar. A leaf stays together, and so do triangles of wood that share vertices.
///
/// A material is not split if its parts would need much more texture than it did, nor into more than kMaxParts parts. Same plant, same
/// result.
/// plant  new materials follow the others; triangle_tints, if any, become base colours and are emptied
void split_materials(Plant& plant);

}  // namespace coppice::bake
