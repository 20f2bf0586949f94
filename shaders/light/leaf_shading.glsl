// Shared by the vertex shader of leaf quads and the compute rasteriser. After bindings.glsl and shading.glsl.

#include "coppice_transparency.h"

vec3 quantised(uint corners[6], uint corner) {
  uint first = corner * 3;
  uvec3 q;
  for (uint axis = 0; axis < 3; ++axis) {
    uint half_word = first + axis;
    q[axis] = (corners[half_word >> 1] >> ((half_word & 1) * 16)) & 0xffffu;
  }
  return vec3(q);
}

uint name_of(Leaf leaf, uint slot) { return leaf_name(leaf.corners[0], leaf.corners[3], leaf.corners[5], slot); }

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
