#version 460
// Sky where nothing was drawn: the fog's colour at the horizon, blue above, the sun and thin clouds. Recorded by record_sky.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec2 clip;
layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_velocity;

void main() {
  vec4 far = frame.world_from_clip * vec4(clip, 1e-6, 1);
  vec3 direction = normalize(far.xyz / far.w - frame.eye.xyz);
  float up = max(direction.y, 0.0);
  vec3 zenith = vec3(0.11, 0.25, 0.58);
  vec3 color = mix(air(direction), zenith, smoothstep(0.03, 0.6, up));

  vec2 plane = direction.xz / (direction.y + 0.12);
  float cloud = 0.65 * texture(ground_detail, plane * 0.045 + frame.eye.w * 0.0004).y +
                0.35 * texture(ground_detail, plane.yx * 0.13 - frame.eye.w * 0.0007).y;
  color = mix(color, vec3(0.92, 0.92, 0.93), 0.7 * smoothstep(0.50, 0.78, cloud) * smoothstep(0.02, 0.25, up));

  float towards_sun = max(dot(direction, frame.sun_direction.xyz), 0.0);
  float glow = towards_sun * towards_sun * towards_sun;
  glow *= glow;
  glow *= glow;
  glow *= glow;  // the 24th power
  color += frame.sun_color.rgb * (0.06 * glow * smoothstep(0.0, 0.3, up) + 6.0 * smoothstep(0.9994, 0.9998, towards_sun));
  out_color = vec4(color, 1);
  out_velocity = kByDepth;
}
