// The descriptor set of every pass of the demo but the overlay, and the light they share.
#extension GL_GOOGLE_include_directive : require
#include "frame_uniforms.h"

// Shadow maps: 0 none, 1 looked at once, 2 with soft edges. A constant: software drivers run both sides of a branch.
layout(constant_id = 0) const uint kShadowMaps = 0;

layout(set = 0, binding = 0) uniform Frame { FrameUniforms frame; };
layout(set = 0, binding = 1) uniform sampler2D ground_map;
layout(set = 0, binding = 2) uniform sampler2D ground_detail;
layout(set = 0, binding = 3) uniform sampler2D scene_color;
layout(set = 0, binding = 4) uniform sampler2D shadow_map_0;
layout(set = 0, binding = 5) uniform sampler2D shadow_map_1;
layout(set = 0, binding = 6) uniform sampler2D shadow_map_2;
layout(set = 0, binding = 7) uniform sampler2D blended;

// 1: unobscured by fog.
float transmittance(vec3 position) {
  float depth = frame.fog.w * distance(position, frame.eye.xyz);
  return exp(-depth * depth);
}
vec3 fogged(vec3 color, vec3 position) { return mix(frame.fog.rgb, color, transmittance(position)); }

// x sunlight let through, y trodden, z open sky, w lushness; neutral values beyond the planted square.
vec4 ground_state(vec2 at) {
  vec2 unit = at / frame.ground.x;
  float outside = smoothstep(0.9, 1.0, max(abs(unit.x), abs(unit.y)));
  return mix(texture(ground_map, 0.5 + 0.5 * unit), vec4(0.8, 0.0, 0.9, 0.5), outside);
}

// Share of the sun that a map lets through; bilinear over the comparisons of four texels. Depth is reversed.
float sun_in_map(sampler2D map, vec3 place) {
  vec4 nearer = vec4(greaterThan(textureGather(map, place.xy), vec4(place.z)));
  vec2 share = fract(place.xy * vec2(textureSize(map, 0)) - 0.5);
  return 1.0 - mix(mix(nearer.w, nearer.z, share.x), mix(nearer.x, nearer.y, share.x), share.y);
}

// Four of them about a place: edges of one and a half texels.
float soft_sun_in_map(sampler2D map, vec3 place) {
  if (kShadowMaps == 1) return sun_in_map(map, place);
  vec2 texel = 0.75 / vec2(textureSize(map, 0));
  return 0.25 * (sun_in_map(map, place + vec3(texel, 0.0)) + sun_in_map(map, place - vec3(texel, 0.0)) +
                 sun_in_map(map, place + vec3(texel.x, -texel.y, 0.0)) + sun_in_map(map, place - vec3(texel.x, -texel.y, 0.0)));
}

vec3 place_in_map(int cascade, vec3 world) {
  vec4 clip = frame.shadows[cascade] * vec4(world, 1.0);
  return vec3(0.5 + 0.5 * clip.xy / clip.w, clip.z / clip.w);
}
bool is_in_map(vec3 place) { return all(lessThan(abs(place.xy - 0.5), vec2(0.49))); }

// Share of the sun at a place that casts no shadow itself. unmapped: where there is no map
float sunlight(vec3 world, float unmapped) {
  if (kShadowMaps == 0) return unmapped;
  vec3 place = place_in_map(0, world);
  if (is_in_map(place)) return soft_sun_in_map(shadow_map_0, place);
  place = place_in_map(1, world);
  if (is_in_map(place)) return soft_sun_in_map(shadow_map_1, place);
  place = place_in_map(2, world);
  return is_in_map(place) ? sun_in_map(shadow_map_2, place) : unmapped;
}

vec3 ambient(vec3 normal) {
  return mix(frame.ground_color.rgb, frame.sky_color.rgb, 0.5 + 0.5 * normal.y);
}
