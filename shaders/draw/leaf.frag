#version 460
#extension GL_GOOGLE_include_directive : require

// Leaf quads: gaps, texture, alpha test, fog; with COPPICE_DEPTH, for shadow maps, no colour.
// reads     view; base_color
// writes    colour, linear
// draws     of leaf.vert, in coppice::gpu::ViewRecorder::record_draw. What has neither texture nor gaps keeps early depth tests.

#include "bindings.glsl"
#include "surface_in.glsl"
#include "coppice_thinning.h"

layout(push_constant, scalar) uniform Push { DrawPush push; };
layout(constant_id = 2) const uint kGaps = 1;

layout(location = 4) flat in uint in_thinning;
#ifndef COPPICE_DEPTH
layout(location = 0) out vec4 out_color;
#endif

void main() {
  uvec2 pixel = uvec2(gl_FragCoord.xy) - view.eyes[push.eye].first_px;
  if (kGaps != 0 && !shows_pixel(in_thinning, pixel.x, pixel.y)) discard;
  vec3 color = textured(in_color);  // lit alike on both sides
#ifndef COPPICE_DEPTH
  out_color = fogged(color);
#endif
}
