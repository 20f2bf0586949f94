// Light shared by leaves and wood. Per vertex: a leaf is a few pixels wide, so that a fragment has nothing to add but its texture.
// After bindings.glsl.

#include "coppice_light.h"

vec3 ambient_light(vec3 normal) { return mix(view.ground_color, view.sky_color, 0.5 + 0.5 * normal.y); }

// 1: unobscured by fog. A parallel view's begins at the plane of its eye.
float transmittance(vec3 world) {
  float from_plane_m = max(-dot(view.toward_viewer, world), 0.0);
  float optical_depth = view.fog_density * (from_plane_m + view.is_perspective * length(world));
  return exp(-optical_depth * optical_depth);
}

Crown crown_of(Plant plant) { return crown_of(plant.box_min, plant.box_step, plant.quantised_max); }

// The share of a plant's leaves that a cut has merged.
float merged_share(Plant plant, uint leaf_count) { return 1.0 - float(min(leaf_count, plant.leaf_count)) / float(plant.leaf_count); }

// leaves: as below
float crown_sky(float sky, float leaves) { return mix(1.0, sky, leaves); }
float leaf_sky(float sky, float bulk, float leaves) { return mix(crown_sky(sky, leaves), 1.0, kBulkSky * bulk); }

// Of a leaf that stands for a crown: how bright a ball is, all of it that the eye sees, of leaves that turn outwards. cosine: of the angle
// between eye and sun. The first term is close to Lambert's phase law, 0.85 (sin a + (pi - a) cos a) / pi.
float bulk_front(float cosine) {
  float lit = 0.5 + 0.5 * cosine;
  return 0.53 * lit * sqrt(lit) + 0.15;
}

// Share of the sun that reaches a leaf or wood. What a leaf of some bulk stands for the eye sees from outside: it is lit as the crown's
// near side is, where the way of light is short with the sun behind the eye, and all through the crown against it.
// leaves: the share of the crown's that there is
float sun_through_crown(CrownSample light, vec3 sun, vec3 eye, float bulk, float leaves) {
  float depth = mix(max(light.depth + dot(light.slope, sun), 0.0), 2.0 * light.depth * max(0.0, -dot(eye, sun)), bulk);
  return mix(0.05, 1.0, exp(-leaves * depth));
}

// What a leaf of some bulk sends to the eye of the sun that reaches it, from its front and, of a single leaf, through it. ball: bulk_front
vec3 sun_on_leaf(LeafNormals normals, vec3 sun, vec3 eye, float ball, float bulk) {
  float front = mix(max(0.0, 0.2 + 0.8 * dot(normals.lit, sun)), ball, bulk);
  float through = max(0.0, -sign(dot(normals.face, eye)) * dot(normals.face, sun)) * (1.0 - bulk);
  return front + 0.45 * through * vec3(1.0, 1.15, 0.35);
}

// Share of the sun that a map lets through to a place in it; bilinear over the comparisons of four texels.
float sun_in(sampler2D map, vec3 place) {
  vec4 nearer = vec4(greaterThan(view.depth_sign * (textureGather(map, place.xy) - place.z), vec4(1e-5)));
  vec2 share = fract(place.xy * vec2(textureSize(map, 0)) - 0.5);
  return 1.0 - mix(mix(nearer.w, nearer.z, share.x), mix(nearer.x, nearer.y, share.x), share.y);
}

// Each map by its own number: nothing asks the device to index samplers.
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

// Share of the sun that other things than the plant itself let through to a place of it: what the maps hold where the sun's ray enters the
// plant's sphere. Nothing can shade itself by rounding there, and the maps may show coarser cuts.
float sun_past_others(Instance instance, Plant plant, vec3 world) {
  vec3 off = world - world_from_object(instance, plant.sphere_center);
  float radius_m = instance.scale * plant.sphere_radius;
  float along = dot(off, view.sun_direction);
  vec3 entry = world + view.sun_direction * max(sqrt(max(along * along - dot(off, off) + radius_m * radius_m, 0.0)) - along, 0.0);
  vec3 place = vec3(0.0);
  uint map = 0;
  for (; map < view.shadow_map_count; ++map) {
    place = place_in_map(map, entry);
    if (is_in_map(place)) break;
  }
  return map < view.shadow_map_count ? sun_in_map(map, place) : 1.0;
}

// A leaf, or a place on it. Object space.
struct LeafPlace {
  vec3 middle;  // of the leaf, or near it
  vec3 vertex;
  vec3 face;    // the leaf's normal there, of any length and either side
  float crown_normals;  // Material's
  float bulk;
};

// Light of a leaf at one of its vertices, two-sided, with the sun shining through.
// light: of its middle
vec3 leaf_light(Plant plant, Crown crown, CrownSample light, Instance instance, LeafPlace leaf) {
  LeafNormals normals = leaf_normals(crown, leaf.middle, leaf.face, leaf.crown_normals);
  vec4 to_object = vec4(-instance.rotation.xyz, instance.rotation.w);
  vec3 world = world_from_object(instance, leaf.vertex);
  vec3 eye = rotate(to_object, toward_eye(world));
  vec3 sun_object = rotate(to_object, view.sun_direction);
  float leaves = leaf_share_of(instance);
  float sun = sun_through_crown(light, sun_object, eye, leaf.bulk, leaves) * sun_past_others(instance, plant, world);
  vec3 direct = view.sun_color * sun * sun_on_leaf(normals, sun_object, eye, bulk_front(dot(eye, sun_object)), leaf.bulk);
  return direct + ambient_light(rotate(instance.rotation, mix(normals.lit, 0.67 * eye, leaf.bulk))) * leaf_sky(light.sky, leaf.bulk, leaves);
}

// What reaches a point of wood.
struct WoodLight {
  vec3 sun;
  float sky;
};

WoodLight wood_light_at(Plant plant, Crown crown, Instance instance, vec3 position) {
  vec3 sun_object = rotate(vec4(-instance.rotation.xyz, instance.rotation.w), view.sun_direction);
  CrownSample light = crown_light_at(plant.crown_light, crown, position);
  float past_others = sun_past_others(instance, plant, world_from_object(instance, position));
  float leaves = leaf_share_of(instance);
  float sun = sun_through_crown(light, sun_object, sun_object, 0.0, leaves) * past_others;
  return WoodLight(view.sun_color * sun, crown_sky(light.sky, leaves));
}

// normal: unit, world space, of the side that is seen
vec3 lit(WoodLight light, vec3 normal) {
  return light.sun * max(0.0, dot(normal, view.sun_direction)) + ambient_light(normal) * light.sky;
}
