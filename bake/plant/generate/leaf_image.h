#pragma once

#include "plant.h"
#include "species.h"

namespace coppice::bake {

/// Largest distance of the rim from the midrib, in leaf lengths.
float half_width(const LeafOutline& outline);

/// Paints an image of the leaf that fills the unit square of its texture coordinates: veins on a paler or darker blade around linear 1, to
/// be multiplied by the leaf colour. Alpha is the outline, grown by about a texel so that it never cuts the leaf mesh. It gives a leaf
/// *quad* the leaf's shape.
Image paint_leaf(const LeafOutline& outline, const LeafPaint& paint);

/// Alpha below this is a hole.
inline constexpr float kLeafAlphaCutoff = 0.5f;

}  // namespace coppice::bake
