// Occlusion by the engine's occluder and by earlier culling passes. After raster.glsl.

// The largest depth key of a sphere: the larger k for which the plane dot(key_row - k * w_row, place) = 0 touches it. The sphere lies
// before the eye. middle: on_screen of its centre
float largest_key(uint eye, vec4 middle, float radius_m) {
  mat4 clip = view.eyes[eye].clip_from_world;
  vec3 k = view.eyes[eye].key_row.xyz, w = vec3(clip[0].w, clip[1].w, clip[2].w);
  vec3 slope = middle.w * w - middle.z * k;  // slope of the key at the centre, times -w^2
  vec3 across = cross(k, w);
  float root = sqrt(max(dot(slope, slope) - radius_m * radius_m * dot(across, across), 0.0));
  float square = radius_m * radius_m;
  return (middle.z * middle.w - square * dot(k, w) + radius_m * root) / (middle.z * middle.z - square * dot(w, w));
}

// True if a sphere is hidden from an eye: all tiles that it may touch are covered nearer than its nearest point. False for large spheres.
bool occluded_from(uint eye, vec3 center, float radius_m) {
  vec4 middle = on_screen(eye, vec4(center, 1.0));
  float nearest = middle.z - view.is_perspective * radius_m;
  float key = largest_key(eye, middle, radius_m);
  if (nearest <= 0.0 || key >= 1.0) return false;
  // The projection is an ellipse: its long axis grows with the angle to the view's axis. In a parallel view it is a circle.
  vec2 at = middle.xy / middle.z;
  float stretch = mix(1.0, distance(center, view.eyes[eye].place) / middle.z, view.is_perspective);
  float reach_px = radius_m * view.focal_px / nearest * stretch + 1.0;
  uint level = 0;
  while (level + 1 < kTileLevels && 2.0 * reach_px > float(kTileSide_px << (2 * level))) ++level;
  float side_px = float(kTileSide_px << (2 * level));
  if (2.0 * reach_px > side_px) return false;
  uvec3 tile = tile_level(level);
  if (kEyes > 1) tile.z += eye * tile_count();
  ivec2 last = ivec2(tile.xy) - 1;
  ivec2 low = clamp(ivec2(floor((at - reach_px) / side_px)), ivec2(0), last);
  ivec2 high = clamp(ivec2(floor((at + reach_px) / side_px)), ivec2(0), last);
  uint farthest = min(min(tiles[tile.z + low.y * tile.x + low.x], tiles[tile.z + low.y * tile.x + high.x]),
                      min(tiles[tile.z + high.y * tile.x + low.x], tiles[tile.z + high.y * tile.x + high.x]));
  return floatBitsToUint(max(key, 1e-30)) < farthest;
}

// True if no eye that has the sphere in view sees it.
bool occluded(vec3 center, float radius_m) {
  if (push.culling_pass < push.hides_from) return false;
  if (kEyes == 1) return occluded_from(0, center, radius_m);
  for (uint eye = 0; eye < kEyes; ++eye)
    if (sphere_in_eye(eye, center, radius_m) && !occluded_from(eye, center, radius_m)) return false;
  return true;
}
