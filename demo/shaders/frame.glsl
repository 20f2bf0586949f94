// The descriptor set of every pass of the demo but the overlay, and the light they share.
#extension GL_GOOGLE_include_directive : require
#include "frame_uniforms.h"

// What there is, a constant since software drivers run both sides of a branch. Lowest bits: shadow maps, 0 none, 1 looked at once, 2 with
// soft edges; 4: the map from above; 8: plants are lit here, not by the library.
layout(constant_id = 0) const uint kHas = 0;
const uint kShadowMaps = kHas & 3u;
const bool kSkyMap = (kHas & 4u) != 0, kDeferred = (kHas & 8u) != 0;

layout(set = 0, binding = 0) uniform Frame { FrameUniforms frame; };
layout(set = 0, binding = 1) uniform sampler2D ground_map;
layout(set = 0, binding = 2) uniform sampler2D ground_detail;
layout(set = 0, binding = 3) uniform sampler2D scene_color;
layout(set = 0, binding = 4) uniform sampler2D shadow_map_0;
layout(set = 0, binding = 5) uniform sampler2D shadow_map_1;
layout(set = 0, binding = 6) uniform sampler2D shadow_map_2;
layout(set = 0, binding = 7) uniform sampler2D blended;
layout(set = 0, binding = 8) uniform sampler2D sky_map;
layout(set = 0, binding = 9) uniform sampler2D plant_albedo;
layout(set = 0, binding = 10) uniform sampler2D plant_normal;
layout(set = 0, binding = 11) uniform sampler2D plant_light;
layout(set = 0, binding = 12) uniform sampler2D plant_depth;
layout(set = 0, binding = 13) uniform sampler2D ground_height;
layout(set = 0, binding = 14) uniform sampler2D ground_litter;

// Velocity of what only the camera moves.
const vec4 kByDepth = vec4(0.0, 0.0, 2.0, 0.0);

// ---- air and sky

// 1: unobscured by fog.
float transmittance(vec3 position) {
  float depth = frame.fog.w * distance(position, frame.eye.xyz);
  return exp(-depth * depth);
}

// What haze looks like along a direction: it scatters forwards, so that it is bright and warm about the sun. The library's fog has one
// colour.
vec3 air(vec3 direction) {
  if (!kDeferred) return frame.fog.rgb;
  float towards = 0.5 + 0.5 * dot(direction, frame.sun_direction.xyz);
  return frame.fog.rgb * mix(vec3(0.86, 0.94, 1.04), vec3(1.34, 1.18, 0.92), towards * towards * towards);
}
vec3 fogged(vec3 color, vec3 position) {
  return mix(air(normalize(position - frame.eye.xyz)), color, transmittance(position));
}

// ---- sun

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

vec3 place_in_map(mat4 clip_from_world, vec3 world) {
  vec4 clip = clip_from_world * vec4(world, 1.0);
  return vec3(0.5 + 0.5 * clip.xy / clip.w, clip.z / clip.w);
}
bool is_in_map(vec3 place) { return all(lessThan(abs(place.xy - 0.5), vec2(0.49))); }

// Share of the sun at a place that casts no shadow itself. unmapped: where there is no map
float sunlight(vec3 world, float unmapped) {
  if (kShadowMaps == 0) return unmapped;
  vec3 place = place_in_map(frame.shadows[0], world);
  if (is_in_map(place)) return soft_sun_in_map(shadow_map_0, place);
  place = place_in_map(frame.shadows[1], world);
  if (is_in_map(place)) return soft_sun_in_map(shadow_map_1, place);
  place = place_in_map(frame.shadows[2], world);
  return is_in_map(place) ? sun_in_map(shadow_map_2, place) : unmapped;
}

// ---- sky

// Light of the sky, and of the ground, on a surface: warmer and brighter from the sun's side. normal: any length up to 1
vec3 ambient(vec3 normal) {
  vec3 sky = frame.sky_color.rgb;
  if (kDeferred) sky *= mix(vec3(0.78, 0.88, 1.06), vec3(1.24, 1.12, 0.92), 0.5 + 0.5 * dot(normal, frame.sun_direction.xyz));
  return mix(frame.ground_color.rgb, sky, 0.5 + 0.5 * normal.y);
}

// The share of the sky's light that arrives at a place among plants, by the map from above: of four directions how high what grows there
// hides the sky, at two distances or, on a software driver, at one. A height field hides more than crowns do, which let light through.
// fragment: gl_FragCoord; unmapped: where there is no map
float open_sky(vec3 world, vec2 fragment, float unmapped) {
  if (!kSkyMap) return unmapped;
  vec3 place = place_in_map(frame.sky_map, world);
  float inside = 1.0 - smoothstep(0.38, 0.49, max(abs(place.x - 0.5), abs(place.y - 0.5)));
  // Moved by chance within a texel, so that the mean over pixels and frames goes from one to the next smoothly.
  vec2 chance = fract(52.98292 * fract(vec2(dot(fragment, vec2(0.0671106, 0.0058372)), dot(fragment, vec2(0.0058372, 0.0671106))) +
                                      vec2(0.7548777, 0.5698403) * frame.sky_color.w));
  place.xy += (chance - 0.5) / vec2(textureSize(sky_map, 0));
  float height_per_depth = 1.0 / abs(frame.sky_map[1].z), uv_per_m = 0.5 * abs(frame.sky_map[0].x);
  // Directions turn from pixel to pixel and from frame to frame; means of 2 x 2 pixels have all of them.
  uint turn = (uint(fragment.x) + 2 * uint(fragment.y) + uint(frame.sky_color.w)) & 3u;
  vec2 along = turn < 2 ? vec2(0.98, 0.2) : vec2(0.56, 0.83);
  if ((turn & 1u) != 0) along = vec2(0.7071 * (along.x - along.y), 0.7071 * (along.x + along.y));
  float open = 0.0;
  for (int i = 0; i < 4; ++i) {
    float hidden = 0.0;
    for (int ring = 0; ring < (kShadowMaps == 1 ? 1 : 2); ++ring) {
      float away_m = kShadowMaps == 1 ? 3.5 : ring == 0 ? 2.0 : 6.0;
      float above_m = (textureLod(sky_map, place.xy + away_m * uv_per_m * along, 0.0).x - place.z) * height_per_depth;
      above_m = max(above_m - 0.3, 0.0);
      hidden = max(hidden, above_m * above_m / (above_m * above_m + away_m * away_m));
    }
    open += 0.25 * (1.0 - 0.85 * hidden);
    along = vec2(-along.y, along.x);
  }
  return mix(unmapped, open, inside);
}

// Light that arrives from all round but the sun. open: the share of the sky that is seen; of the rest leaves are
vec3 light_of_surroundings(vec3 normal, float open) {
  vec3 leaves = frame.sun_color.rgb * vec3(0.018, 0.026, 0.008);
  return ambient(normal) * open + (kDeferred ? leaves * (1.0 - open) : vec3(0.0));
}

// ---- ground

// Earth and moss about the foot of a stem, on the ground and on the bark. noise: 0..1
vec3 foot_color(float noise) {
  return mix(vec3(0.072, 0.052, 0.030), vec3(0.062, 0.078, 0.022), smoothstep(0.35, 0.7, noise));
}

// x sunlight let through, y trodden, z open sky, w lushness; neutral values beyond the planted square.
vec4 ground_state(vec2 at) {
  vec2 unit = at / frame.ground.x;
  float outside = smoothstep(0.9, 1.0, max(abs(unit.x), abs(unit.y)));
  return mix(texture(ground_map, 0.5 + 0.5 * unit), vec4(0.8, 0.0, 0.9, 0.5), outside);
}
