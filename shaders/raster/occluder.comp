#version 460
#extension GL_GOOGLE_include_directive : require

// Copies the engine's depth into the picture as an occluder from the first culling pass on: a depth key for each pixel, without a name, and
// the smallest of each tile. A key is smaller than the engine's by more than the rounding of depth formats and interpolation, so whatever
// it hides fails the depth test of the draw.
// reads     view, occluders
// writes    picture, which is empty; tiles of level 0
// dispatch  an invocation a tile, y: eyes; recorded by coppice::gpu::LeafRaster::record_occluder

#include "bindings.glsl"
#include "raster.glsl"

layout(local_size_x_id = 1) in;

const float kSlack = 1.0 / 1048576.0;  // as a share of the key

// False outside the image. Each image has its own branch, because devices need not be able to index samplers.
bool depth_at(uint eye, ivec2 at, out float depth) {
  ivec2 size = eye == 0 ? textureSize(occluders[0], 0) : textureSize(occluders[1], 0);
  bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
  at = clamp(at, ivec2(0), size - 1);
  depth = eye == 0 ? texelFetch(occluders[0], at, 0).x : texelFetch(occluders[1], at, 0).x;
  return inside;
}

// 0 for an empty pixel.
uint key_bits(uint eye, ivec2 at) {
  float depth;
  bool inside = depth_at(eye, at, depth);
  float key = push.reversed != 0 ? depth : 1.0 - depth;
  key -= key * kSlack + push.occluder_step;
  return inside && key > 0.0 ? floatBitsToUint(key) : 0;
}

void main() {
  uint index = gl_GlobalInvocationID.x, eye = gl_WorkGroupID.y;
  uvec3 level = tile_level(0);
  if (index >= level.x * level.y) return;
  uvec2 low = uvec2(index % level.x, index / level.x) * kTileSide_px;
  uvec2 high = min(low + kTileSide_px, uvec2(push.width_px, push.height_px));
  ivec2 from = ivec2(view.eyes[eye].first_px) + ivec2(push.occluder_x_px, push.occluder_y_px);
  uint smallest = 0xffffffffu, first = first_pixel(eye);
  for (uint y = low.y; y < high.y; ++y)
    for (uint x = low.x; x < high.x; ++x) {
      uint bits = key_bits(eye, from + ivec2(x, y));
      if (bits != 0) picture[2 * (first + y * push.width_px + x) + 1] = bits;
      smallest = min(smallest, bits);
    }
  tiles[eye * tile_count() + index] = smallest;
}
