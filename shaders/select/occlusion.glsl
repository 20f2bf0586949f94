// What earlier rounds of the rasteriser hide. After raster.glsl.

// Whether earlier rounds hide a sphere: all tiles it may touch are covered nearer than its nearest point. False for what is large.
bool occluded(vec3 center, float radius_m) {
  vec3 middle = on_screen(vec4(center, 1.0));
  float nearest = middle.z - radius_m;
  if (nearest <= view.near_m) return false;
  // An ellipse on the screen: its long axis grows with the angle to the view's axis.
  vec2 at = middle.xy / middle.z;
  vec2 off = (at - 0.5 * vec2(push.width_px, push.height_px)) / view.focal_px;
  float reach_px = radius_m * view.focal_px / nearest * sqrt(1.0 + dot(off, off)) + 1.0;
  uint level = 0;
  while (level + 1 < kTileLevels && 2.0 * reach_px > float(kTileSide_px << (2 * level))) ++level;
  float side_px = float(kTileSide_px << (2 * level));
  if (2.0 * reach_px > side_px) return false;
  uvec3 tile = tile_level(level);
  ivec2 last = ivec2(tile.xy) - 1;
  ivec2 low = clamp(ivec2(floor((at - reach_px) / side_px)), ivec2(0), last);
  ivec2 high = clamp(ivec2(floor((at + reach_px) / side_px)), ivec2(0), last);
  uint farthest = min(min(tiles[tile.z + low.y * tile.x + low.x], tiles[tile.z + low.y * tile.x + high.x]),
                      min(tiles[tile.z + high.y * tile.x + low.x], tiles[tile.z + high.y * tile.x + high.x]));
  return floatBitsToUint(depth_key(1.0 / nearest)) < farthest;
}
