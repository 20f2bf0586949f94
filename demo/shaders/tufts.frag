#version 460
// A blade of grass, lit like the ground it stands on and from behind; writes linear radiance. Recorded by record_tufts.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 world_position;
layout(location = 1) in float along;
layout(location = 2) in float tone;
layout(location = 0) out vec4 out_color;

void main() {
  vec4 state = ground_state(world_position.xz);
  vec3 albedo = mix(vec3(0.062, 0.112, 0.022), vec3(0.150, 0.146, 0.050), tone * tone);
  float sunlit = mix(0.25 * state.x, state.x, along);
  float sky = (0.25 + 0.75 * along) * (0.35 + 0.65 * state.z);
  vec3 light = frame.sun_color.rgb * (0.62 * sunlit * frame.sun_direction.y) + ambient(vec3(0, 1, 0)) * sky;
  out_color = vec4(fogged(albedo * light, world_position), 1);
}
