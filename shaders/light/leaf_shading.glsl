// Shared by the vertex shader of leaf quads and the compute rasteriser. After bindings.glsl, shading.glsl and clusters.glsl.

#include "coppice_transparency.h"

uint name_of(Leaf leaf, uint seed) { return leaf_name(leaf.corners[0], leaf.corners[3], leaf.corners[5], seed); }

// Side of a leaf, relative to its own, when only a share of the instance's leaves is drawn. Single leaves are drawn or not; merged ones are
// smaller, so that they cover that share.
float shared_side(uint name, bool single, float share) {
  if (share >= 1.0) return 1.0;
  return single ? (is_among(name, share) ? 1.0 : 0.0) : sqrt(share);
}

// at_px: the leaf's middle
uint dither_of(Leaf leaf, uint name, vec2 at_px) {
  uvec2 pixel = uvec2(ivec2(floor(clamp(at_px, -32768.0, 32767.0))));
  return leaf_dither(transparency_of_leaf(leaf.card), name, view.temporal_frame, pixel.x, pixel.y);
}
