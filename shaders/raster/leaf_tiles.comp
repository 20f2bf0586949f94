#version 460
#extension GL_GOOGLE_include_directive : require

// Computes the smallest depth key of each tile: 0 if one of its pixels shows neither a leaf nor the engine's depth.
// reads     picture (level 0), tiles of level 0 (the others)
// writes    tiles
// dispatch  indirect, from the pass's tiles stages, one invocation per tile of level 0, or of levels 1 and 2, y: eyes; recorded by
//           coppice::gpu::LeafRaster::record_tiles; without a pass, after occluder.comp, by record_occluder

#include "bindings.glsl"
#include "raster.glsl"

layout(local_size_x_id = 1) in;
layout(constant_id = 0) const uint kFirstLevel = 0;

uint smallest_of_picture(uint eye, uvec2 tile) {
  uvec2 low = tile * kTileSide_px;
  uvec2 high = min(low + kTileSide_px, uvec2(push.width_px, push.height_px));
  uint smallest = 0xffffffffu, first = first_pixel(eye);
  // Most tiles have a pixel without a leaf: then the other pixels do not matter.
  for (uint y = low.y; y < high.y && smallest != 0; ++y)
    for (uint x = low.x; x < high.x; ++x) smallest = min(smallest, picture_word(2 * (first + y * push.width_px + x) + 1));
  return smallest;
}

uint smallest_of_tiles(uint first, uvec2 tile, uint level) {
  uvec3 finest = tile_level(0);
  uint side = 1u << (2 * level);
  uvec2 low = tile * side;
  uvec2 high = min(low + side, finest.xy);
  uint smallest = 0xffffffffu;
  for (uint y = low.y; y < high.y; ++y)
    for (uint x = low.x; x < high.x; ++x) smallest = min(smallest, tiles[first + y * finest.x + x]);
  return smallest;
}

void main() {
  uint index = gl_GlobalInvocationID.x, eye = gl_WorkGroupID.y, first = eye * tile_count();
  for (uint level = kFirstLevel; level < (kFirstLevel == 0 ? 1 : kTileLevels); ++level) {
    uvec3 size = tile_level(level);
    uint count = size.x * size.y;
    if (index < count) {
      uvec2 tile = uvec2(index % size.x, index / size.x);
      tiles[first + size.z + index] = level == 0 ? smallest_of_picture(eye, tile) : smallest_of_tiles(first, tile, level);
      return;
    }
    index -= count;
  }
}
