#version 460
#extension GL_GOOGLE_include_directive : require

// Wood and leaf meshes: texture, alpha test, fog; with COPPICE_DEPTH, for shadow maps, no colour.
// reads     view; base_color
// writes    colour, linear
// draws     of wood.vert and leaf_mesh.vert, in coppice::gpu::ViewRecorder::record_draw. What has no texture keeps early depth
//           tests.

#include "bindings.glsl"
#include "surface_in.glsl"

layout(location = 4) in vec3 in_back_color;
#ifndef COPPICE_DEPTH
layout(location = 0) out vec4 out_color;
#endif

void main() {
  vec3 color = textured(kLeaf != 0 || is_front() ? in_color : in_back_color);  // leaves are lit alike on both sides
#ifndef COPPICE_DEPTH
  out_color = fogged(color);
#endif
}
