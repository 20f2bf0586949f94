#pragma once

#include "plant.h"

namespace coppice::bake {

/// Gives each material the part of its image that its triangles show, as an image of its own, and fills what no triangle shows of an opaque
/// one with the colours beside it. Artists put bark, leaves and the white paper between them into one picture: from afar, where a pixel
/// is many texels, a leaf must not take on bark and paper, nor a trunk the mean of all of it.
///
/// Only where a quarter of the image or more falls away, and only on axes along which all of the material's texture coordinates are in one
/// period; normal maps are cut alike. Holes of alpha-tested images stay as they are. Same plant, same result.
/// plant  foliage, wood, materials and images are changed; images that no material names any more stay (drop_unused_materials)
void cut_texture_regions(Plant& plant);

}  // namespace coppice::bake
