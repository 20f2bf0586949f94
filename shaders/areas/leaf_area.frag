#version 460
#extension GL_GOOGLE_include_directive : require
// Reads masks and holes: the nearest texel, repeating. Writes nothing and discards holes. Drawn by OcclusionAreas
// (bake/lod/areas/occlusion_areas.cpp).
#include "leaf_area.glsl"

layout(location = 0) noperspective in vec2 uv;
layout(location = 1) flat in uint mask;

void main() {
  Mask shown = masks.masks[mask];
  if (shown.width == 0u) return;
  uvec2 size = uvec2(shown.width, shown.height);
  uvec2 texel = min(uvec2(fract(uv) * vec2(size)), size - 1u);
  uint index = texel.y * size.x + texel.x;
  if ((holes.words[shown.first_word + index / 32u] >> (index % 32u) & 1u) != 0u) discard;
}
