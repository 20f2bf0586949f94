#version 460
#extension GL_GOOGLE_include_directive : require
// Reads leaves, six vertices each: triangles (0, 1, 2) and (0, 2, 3). Writes depth only. Drawn by OcclusionAreas
// (bake/lod/areas/occlusion_areas.cpp): all leaves at once for the depth, then one by one to count each leaf's pixels at that depth. The
// draws must give the same depth to the bit: all pipelines are made from this one module, and nothing in it may be rearranged.
#include "leaf_area.glsl"

// Linear on the screen, as in the baker's rasteriser, in perspective too.
layout(location = 0) noperspective out vec2 uv;
layout(location = 1) flat out uint mask;

const uint kCorners[6] = uint[](0, 1, 2, 0, 2, 3);

void main() {
  uint leaf = uint(gl_VertexIndex) / 6u;
  uint corner = kCorners[uint(gl_VertexIndex) % 6u];
  vec3 position = vec3(leaves.leaves[leaf].corners[3u * corner], leaves.leaves[leaf].corners[3u * corner + 1u],
                       leaves.leaves[leaf].corners[3u * corner + 2u]);
  precise vec4 clip = clip_from_sphere * vec4(position, 1.0);
  gl_Position = clip;
  uv = vec2(leaves.leaves[leaf].uvs[2u * corner], leaves.leaves[leaf].uvs[2u * corner + 1u]);
  mask = leaves.leaves[leaf].mask;
}
