#version 460
// A blade of grass: the light of its vertices, and the sun where maps let it through; writes linear radiance. Recorded by record_tufts.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 shaded;
layout(location = 1) in vec3 sunlit;
layout(location = 2) flat in vec4 open;
layout(location = 3) in vec3 now;
layout(location = 4) in vec3 before;
layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_velocity;

void main() {
  out_color = vec4(shaded + sunlit * sunlight(open.xyz, open.w), 1);
  out_velocity = vec4(0.5 * frame.drawn_px.xy * (now.xy / now.z - before.xy / before.z), 0, 0);
}
