// The sun and sky that reach places of leaves and wood. After bindings.glsl.

#include "coppice_light.h"
#include "coppice_surface.glsl"

// 1: unobscured by fog. In a parallel view fog begins at the plane of the eye.
float transmittance(vec3 world) {
  float from_plane_m = max(-dot(view.toward_viewer, world), 0.0);
  float optical_depth = view.fog_density * (from_plane_m + view.is_perspective * length(world));
  return exp(-optical_depth * optical_depth);
}

Crown crown_of(Plant plant) { return crown_of(plant.box_min, plant.box_step, plant.quantised_max); }

// Share of the sky that reaches a leaf or wood. leaves: the share of the crown's leaves that is drawn
float crown_sky(float sky, float leaves) { return mix(1.0, sky, leaves); }

// The same of the sun. sun: object space
float sun_through_crown(CrownSample light, vec3 sun, float leaves) {
  return mix(0.05, 1.0, exp(-leaves * max(light.depth + dot(light.slope, sun), 0.0)));
}

// Share of the sun that a map lets through to a place in it; bilinear over the comparisons of four texels.
float sun_in(sampler2D map, vec3 place) {
  vec4 nearer = vec4(greaterThan(view.depth_sign * (textureGather(map, place.xy) - place.z), vec4(1e-5)));
  vec2 share = fract(place.xy * vec2(textureSize(map, 0)) - 0.5);
  return 1.0 - mix(mix(nearer.w, nearer.z, share.x), mix(nearer.x, nearer.y, share.x), share.y);
}

// Each map has its own branch, because devices need not be able to index samplers.
float sun_in_map(uint map, vec3 place) {
  switch (map) {
    case 0: return sun_in(shadow_maps[0], place);
    case 1: return sun_in(shadow_maps[1], place);
    case 2: return sun_in(shadow_maps[2], place);
    default: return sun_in(shadow_maps[3], place);
  }
}

// x, y: place in a shadow map; z: its depth there.
vec3 place_in_map(uint map, vec3 world) {
  vec4 clip = view.map_clips[map] * vec4(world, 1.0);
  return vec3(0.5 + 0.5 * clip.xy / clip.w, clip.z / clip.w);
}
bool is_in_map(vec3 place) { return all(lessThan(abs(place.xy - 0.5), vec2(0.49))); }

// Share of the sun that other things than the plant itself let through to a place of it. The maps are read where the sun's ray enters the
// plant's sphere: there nothing can shade itself by rounding, and the maps may show coarser cuts.
float sun_past_others(Instance instance, Plant plant, vec3 world) {
  vec3 off = world - world_from_object(instance, plant.sphere_center);
  float radius_m = instance.scale * plant.sphere_radius;
  float along = dot(off, view.sun_direction);
  vec3 entry = world + view.sun_direction * max(sqrt(max(along * along - dot(off, off) + radius_m * radius_m, 0.0)) - along, 0.0);
  vec3 place = vec3(0.0);
  uint map = 0, map_count = min(view.shadow_map_count, kMaxShadowMaps);
  for (; map < map_count; ++map) {
    place = place_in_map(map, entry);
    if (is_in_map(place)) break;
  }
  return map < map_count ? sun_in_map(map, place) : 1.0;
}

// The share of the sun on a leaf's back that shines through it.
const float kLeafTranslucency = 0.45;

LeafNormals in_world(Instance instance, LeafNormals normals) {
  return LeafNormals(oriented(instance.rotation, normals.axis), normals.along, normals.sided);
}

// The light at a leaf, or at a place of it.
struct LeafLight {
  CrownSample crown;  // object space
  float past_others;  // sun_past_others
};

// The surface of a leaf in the light at its place. normals: world space
CoppiceSurface leaf_surface(Instance instance, LeafLight light, LeafNormals normals, vec3 world) {
  vec4 to_object = vec4(-instance.rotation.xyz, instance.rotation.w);
  vec3 eye = toward_eye(world);
  float leaves = leaf_share_of(instance);
  CoppiceSurface surface;
  surface.albedo = tint_of(instance);
  surface.occlusion = crown_sky(light.crown.sky, leaves);
  surface.normal = normals.sided == 0.0 && dot(normals.axis, eye) < 0.0 ? -normals.axis : normals.axis;
  surface.roughness = 1.0;
  surface.along = normals.along;
  surface.sided = normals.sided;
  surface.translucency = kLeafTranslucency;
  surface.sun = light.past_others * sun_through_crown(light.crown, oriented(to_object, view.sun_direction), leaves);
  return surface;
}

// The same for wood. normal: on the visible side, world space
CoppiceSurface wood_surface(Instance instance, LeafLight light, vec3 normal) {
  vec3 sun = oriented(vec4(-instance.rotation.xyz, instance.rotation.w), view.sun_direction);
  float leaves = leaf_share_of(instance);
  CoppiceSurface surface;
  surface.albedo = vec3(1.0);
  surface.occlusion = crown_sky(light.crown.sky, leaves);
  surface.normal = normal;
  surface.roughness = surface.along = surface.sided = 1.0;  // a smooth normal may turn away from the eye, and stays
  surface.translucency = 0.0;
  surface.sun = light.past_others * sun_through_crown(light.crown, sun, leaves);
  return surface;
}
