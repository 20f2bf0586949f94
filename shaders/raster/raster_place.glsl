// An instance's list on its way to the screen, and the light of what is in it. After bindings.glsl.
// Loads are what software drivers spend most on, so that a leaf brings all its light needs in two words.

#include "shading.glsl"
#include "raster.glsl"
#include "radiance.glsl"
#include "debug_view.glsl"

// What the leaves of a cluster share; directions in object space.
struct Placed {
  vec4 origin, x, y, z;  // on_screen of a place: origin + q.x * x + q.y * y + q.z * z
  vec3 sun, up, eye;
  vec3 sun_color;  // that other plants let through
  float bulk;     // how much of the crown its leaves stand for, in the mean
  float leaves;   // share of the crown's that there is
  float bulk_front, bulk_up;  // in place of a normal's
  vec3 tint;
  float clear;    // share of light that fog lets through
  bool wood;
  uvec2 cards;
  // The view's: loaded here once, not by every leaf.
  vec3 sky_color, ground_color, fog_color;
};

// step: object space, m, of one in q; quarter: shown_quarter; leaf_count: of the cut
Placed place(uint eye, uint item, Instance instance, vec3 box_min, vec3 step, Cluster cluster, uint quarter, uint leaf_count) {
  Plant plant = plants[instance.plant];
  vec4 to_object = vec4(-instance.rotation.xyz, instance.rotation.w);
  Placed placed;
  placed.wood = list_of(item) >= kWoodLists && list_of(item) < kMeshLists;
  placed.cards = plant.card_looks;
  placed.origin = on_screen(eye, vec4(world_from_object(instance, box_min), 1.0));
  placed.x = on_screen(eye, vec4(rotate(instance.rotation, vec3(instance.scale * step.x, 0.0, 0.0)), 0.0));
  placed.y = on_screen(eye, vec4(rotate(instance.rotation, vec3(0.0, instance.scale * step.y, 0.0)), 0.0));
  placed.z = on_screen(eye, vec4(rotate(instance.rotation, vec3(0.0, 0.0, instance.scale * step.z)), 0.0));
  placed.sun = rotate(to_object, view.sun_direction);
  placed.up = rotate(to_object, vec3(0.0, 1.0, 0.0));
  vec3 world = world_from_object(instance, cluster.center);
  placed.eye = rotate(to_object, toward_eye(world));
  placed.bulk = unpackUnorm4x8(cluster.bulks)[quarter] * merged_share(plant, leaf_count);
  placed.leaves = leaf_share_of(instance);
  placed.bulk_front = bulk_front(dot(placed.eye, placed.sun));
  placed.bulk_up = 0.67 * dot(placed.eye, placed.up);
  // Shadows of other plants are soft enough to be the cluster's.
  placed.sun_color = view.sun_color * sun_past_others(instance, plant, world);
  placed.clear = transmittance(world);
  placed.tint = placed.wood ? vec3(1.0) : tint_of(instance);
  placed.sky_color = view.sky_color;
  placed.ground_color = view.ground_color;
  placed.fog_color = view.fog_color;
  if (view.debug_view != 0) {  // in place of light: fog that hides everything has the colour
    placed.fog_color = debug_color(slot_of(item)) * (placed.wood && view.debug_view == kDebugPath ? 0.3 : 1.0);
    placed.clear = 0.0;
  }
  return placed;
}

LeafNormals normals_of(Splat splat) {
  vec4 folded = unpackSnorm4x8(splat.normals);
  return LeafNormals(unfold(folded.xy), unfold(folded.zw));
}

vec4 projected(Placed placed, vec3 q) { return placed.origin + q.x * placed.x + q.y * placed.y + q.z * placed.z; }

uint placed_radiance(Placed placed, Splat splat, LeafNormals normals) {
  vec4 look = unpackUnorm4x8(splat.look);
  if (placed.wood && dot(normals.face, placed.eye) < 0.0) normals.lit = -normals.lit;
  vec3 shown = placed.wood ? vec3(max(0.0, dot(normals.lit, placed.sun)))
                           : sun_on_leaf(normals, placed.sun, placed.eye, placed.bulk_front, placed.bulk);
  vec3 sunlight = placed.sun_color * sun_through_crown(unpack_crown(splat.crown), placed.sun, placed.eye, placed.bulk, placed.leaves);
  float up = mix(dot(normals.lit, placed.up), placed.bulk_up, placed.bulk);
  vec3 light = sunlight * shown + mix(placed.ground_color, placed.sky_color, 0.5 + 0.5 * up) * leaf_sky(look.a, placed.bulk, placed.leaves);
  vec3 albedo = placed.tint * (kMaxSplatAlbedo * look.rgb * look.rgb);
  return pack_radiance(mix(placed.fog_color, albedo * light, placed.clear));
}
