#version 460
#extension GL_GOOGLE_include_directive : require

// Leaves and wood: texture, alpha test, fog; with COPPICE_DEPTH, for shadow maps, no colour.
// reads     view, the texture of the draw
// writes    colour, linear
// recorded by coppice::gpu::record_draw. What has no texture keeps early depth tests.

#include "bindings.glsl"

layout(constant_id = 0) const uint kTextured = 1;
layout(constant_id = 1) const uint kLeaf = 0;  // lit alike on both sides; else wood

layout(set = 1, binding = 0) uniform sampler2D base_color;

layout(location = 0) in vec3 in_light;
layout(location = 1) in float in_transmittance;
layout(location = 2) in vec2 in_uv;
layout(location = 3) flat in float in_alpha_cutoff;
layout(location = 4) in vec3 in_back_light;
#ifndef COPPICE_DEPTH
layout(location = 0) out vec4 out_color;
#endif

void main() {
  vec3 color = kLeaf != 0 || is_front(gl_FrontFacing) ? in_light : in_back_light;
  if (kTextured != 0) {
    vec4 texel = texture(base_color, in_uv);
    if (texel.a < in_alpha_cutoff) discard;
    if (view.debug_view == 0) color *= texel.rgb;
  }
#ifndef COPPICE_DEPTH
  out_color = vec4(mix(view.fog_color, color, in_transmittance), 1.0);
#endif
}
