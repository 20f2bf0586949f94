// The descriptor set of every pass of the demo but the overlay, and the light they share.
#extension GL_GOOGLE_include_directive : require
#include "frame_uniforms.h"

layout(set = 0, binding = 0) uniform Frame { FrameUniforms frame; };
layout(set = 0, binding = 1) uniform sampler2D ground_map;
layout(set = 0, binding = 2) uniform sampler2D ground_detail;
layout(set = 0, binding = 3) uniform sampler2D scene_color;

vec3 fogged(vec3 color, vec3 position) {
  float depth = frame.fog.w * distance(position, frame.eye.xyz);
  return mix(frame.fog.rgb, color, exp(-depth * depth));
}

// x sunlight let through, y trodden, z open sky, w lushness; neutral values beyond the planted square.
vec4 ground_state(vec2 at) {
  vec2 unit = at / frame.ground.x;
  float outside = smoothstep(0.9, 1.0, max(abs(unit.x), abs(unit.y)));
  return mix(texture(ground_map, 0.5 + 0.5 * unit), vec4(0.8, 0.0, 0.9, 0.5), outside);
}

vec3 ambient(vec3 normal) {
  return mix(frame.ground_color.rgb, frame.sky_color.rgb, 0.5 + 0.5 * normal.y);
}
