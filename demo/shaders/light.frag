#version 460
// The demo's own light on what plants have written of their surfaces: sun with gloss, what shines through leaves, a sky that is not alike on
// all sides, and less of it between crowns. Reads plant_albedo, plant_normal, plant_light and plant_depth texel by texel, and the map from
// above; writes linear radiance. Recorded by record_light.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "coppice_surface.glsl"

layout(location = 0) in vec2 clip;
layout(location = 0) out vec4 out_color;

float fifth_power(float x) { return x * x * (x * x) * x; }

// What a surface throws back without taking its colour: the sun's image, as wide as it is rough, and at a flat angle the sky. Leaves are
// waxed, whatever their file says; what stands for many turns every way.
vec3 gloss(CoppiceSurface s, vec3 eye, float open) {
  vec3 normal = s.translucency > 0.0 && dot(s.normal, eye) < 0.0 ? -s.normal : s.normal;
  float roughness = s.translucency > 0.0 ? clamp(s.roughness, 0.55, 0.75) : max(s.roughness, 0.35);
  vec3 sun = frame.sun_direction.xyz, between = normalize(eye + sun);
  float alpha = roughness * roughness, exponent = 2.0 / (alpha * alpha) - 2.0;
  float mirrored = 0.04 + 0.96 * fifth_power(1.0 - max(dot(eye, between), 0.0));
  float lobe = (exponent + 2.0) * 0.125 * pow(max(dot(normal, between), 0.0), exponent) * max(dot(normal, sun), 0.0);
  // A leaf mirrors only the sky that other leaves do not hide, and they hide most of the sky that is not above.
  float up = clamp(2.0 * dot(eye, normal) * normal.y - eye.y, 0.0, 1.0);
  float rim = (0.03 + 0.25 * (1.0 - roughness) * fifth_power(1.0 - max(dot(normal, eye), 0.0))) * up * open * open;
  return coppice_flatness(s.along) * (mirrored * lobe * s.sun * frame.sun_color.rgb + rim * frame.sky_color.rgb);
}

// Where a stem comes out of the ground it is dark, and takes on the ground's colour and light: no line shows where they meet.
// above_m: the ground
void stand_on_ground(inout CoppiceSurface s, vec3 world, float above_m) {
  float noise = 0.5 + 0.4 * sin(21.0 * world.x + 9.0 * world.y - 19.0 * world.z);
  float low = frame.ground_color.w * clamp(1.35 - 1.6 * above_m - 0.7 * noise, 0.0, 1.0);
  s.occlusion *= 1.0 - 0.35 * low;
  low *= s.translucency > 0.0 ? 0.0 : 1.0;
  s.albedo = mix(s.albedo, foot_color(noise), 0.85 * low);
  s.normal = mix(s.normal, vec3(0.0, 1.0, 0.0), 0.35 * low);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(plant_depth, at, 0).x;
  if (depth == 0.0) discard;
  vec4 albedo = texelFetch(plant_albedo, at, 0);
  CoppiceSurface s = coppice_surface(albedo, texelFetch(plant_normal, at, 0), texelFetch(plant_light, at, 0));
  vec4 place = frame.world_from_clip * vec4(clip, depth, 1.0);
  vec3 world = place.xyz / place.w;
  float above_m = world.y - textureLod(ground_height, 0.5 + 0.5 * world.xz / frame.ground.x, 0.0).x;
  stand_on_ground(s, world, above_m);
  vec3 eye = normalize(frame.eye.xyz - world);
  float open = min(s.occlusion, open_sky(world, gl_FragCoord.xy, 1.0));
  CoppiceLight sun = CoppiceLight(frame.sun_direction.xyz, frame.sun_color.rgb, vec3(0.0), vec3(0.0));
  vec3 turned = coppice_mean_normal(s.normal, s.along, eye, s.sided);
  vec3 color = coppice_lit(s, eye, sun) + s.albedo * light_of_surroundings(turned, open) + gloss(s, eye, open);
  out_color = vec4(frame.sun_color.w > 0.0 ? albedo.rgb : fogged(color, world), 1.0);
}
