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

// 0 for a leaf that shows its card's outline, 1 for one that is too small for it. No mip level keeps an outline of few pixels, so a small
// leaf becomes a smaller quad of the same covered area, without holes.
float outline_loss(float thickness_px) { return 1.0 - smoothstep(1.5, 5.0, thickness_px); }

// world_middle: out, the place of the leaf's middle
float outline_loss(vec3 corners[4], Instance instance, out vec3 world_middle) {
  vec3 stalk = 0.5 * (corners[0] + corners[3]), tip = 0.5 * (corners[1] + corners[2]);
  float width_m = distance(0.5 * (corners[0] + corners[1]), 0.5 * (corners[2] + corners[3]));
  world_middle = world_from_object(instance, 0.5 * (stalk + tip));
  float distance_m = max(size_distance_m(world_middle), view.near_m);
  return outline_loss(instance.scale * min(distance(stalk, tip), width_m) * view.focal_px / distance_m);
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
