#version 460
// A blade of grass: the light of its vertices, and the sun where maps let it through; writes linear radiance. Recorded by record_tufts.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 shaded;
layout(location = 1) in vec3 sunlit;
layout(location = 2) flat in vec4 open;
layout(location = 0) out vec4 out_color;

void main() {
  out_color = vec4(shaded + sunlit * sunlight(open.xyz, open.w), 1);
}
