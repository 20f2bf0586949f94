// Wind for shaders. After bindings.glsl.

#ifndef COPPICE_WIND_GLSL
#define COPPICE_WIND_GLSL

#include "coppice_wind.h"
#include "motion.glsl"

CoppiceTable table_of(uint plant) { return CoppiceTable(plant * kTableStride, 0, 0, 0); }

// Maximum motion of a leaf's tip by flutter at full load, object space, m.
float flutter_reach_m(Instance instance) {
  float left_m = kMaxWindReach * plants[plant_of(instance)].sphere_radius - wind_float(table_of(plant_of(instance)), kReachWord);
  return clamp(left_m, 0.0, kFlutterReach * plants[plant_of(instance)].sphere_radius);
}

// Maximum motion of a place of an instance, m in the world.
float wind_reach_m(Instance instance) {
  float reach_m = wind_float(table_of(plant_of(instance)), kReachWord) + flutter_reach_m(instance);
  return instance.scale * view.wind.max_load * reach_m;
}

vec3 foot_of(Instance instance) { return from_eye(unpack_cell(instance.cell_xy, instance.cell_z_bias), instance.position); }

Sway sway_in(WindNow wind, PlantWind field, Instance instance) {
  return sway_of(wind, field, instance.rotation, foot_of(instance), instance.position);
}

// Motion near a place; object space, m: the place moves by offset, its surroundings by grow in addition. Bending is not linear over a whole
// plant: what is h m above or below the place moves by h^2 arc too.
struct WindNear {
  vec3 offset;
  mat3 grow;
  vec3 arc;
};

// radius_m: of the surroundings. A gradient is only valid within its cells: larger things move like their middle.
WindNear wind_near(PlantWind field, WindPlace middle, WindGradient gradient, float radius_m, Sway sway) {
  vec3 near = min(vec3(1.0), 1.0 / max(field.nodes_per_m * radius_m, vec3(1e-6)));
  WindNear moved;
  moved.offset = wind_offset(middle, sway);
  moved.grow[0] = near.x * grid_offset(gradient.grid_x, sway);
  moved.grow[1] = near.y * grid_offset(gradient.grid_y, sway) + bend_offset(gradient.bend_y, sway);
  moved.grow[2] = near.z * grid_offset(gradient.grid_z, sway);
  // Below the ground nothing bends.
  float per_m2 = middle.bend.x > 0.0 ? field.per_height_m * field.per_height_m : 0.0;
  moved.arc = per_m2 * bend_offset(vec2(1.0, 3.0 * sqrt(middle.bend.x)), sway);
  return moved;
}

// Motion of a place of an instance by wind, object space, m: now, and in the frame before. Loads: as in Sway
struct WindMoves {
  vec3 now, before;
  float load, load_before;
};

// p: at rest; anchor: where the grid is asked, at rest
WindMoves wind_moves(Instance instance, vec3 p, vec3 anchor) {
  CoppiceTable table = table_of(plant_of(instance));
  PlantWind field = plant_wind(table);
  WindGradient unused;
  WindPlace place = wind_place(table, field, anchor, unused);
  place.bend = bend_at(field, p.y);
  Sway now = sway_in(view.wind, field, instance), before = sway_in(view.wind_before, field, instance_before(instance));
  return WindMoves(wind_offset(place, now), wind_offset(place, before), now.load, before.load);
}

// Leaves turn about their stalks: the angle at full load, rad; the frequency; and the widths on the screen between which it sets in. Leaves
// drawn as small ones do not flutter.
const float kFlutter_rad = 0.07, kFlutter_hz = 2.5;
const vec2 kFlutter_px = vec2(12.0, 40.0);

// Strength for a leaf of size_m, 0..1. place: object space
float flutter_strength(Instance instance, vec3 place, float size_m) {
  float distance_m = max(size_distance_m(world_from_object(instance, place)), view.near_m);
  float size_px = instance.scale * size_m * view.focal_px / distance_m;
  return view.is_shadow != 0 ? 0.0 : clamp((size_px - kFlutter_px.x) / (kFlutter_px.y - kFlutter_px.x), 0.0, 1.0);
}

// How far a place of a leaf swings to either side, object space, m. along_m: distance from its stalk
float flutter_swing_m(Instance instance, float along_m) { return min(kFlutter_rad * along_m, flutter_reach_m(instance)); }

// Offset of a place of a leaf, object space, m. load: WindMoves'; name: flutter_name, the same in every form of the leaf; swing: the leaf's
// normal, flutter_swing_m long, times flutter_strength
vec3 flutter(float load, float time_s, uint name, vec3 swing) {
  float turns = float(coppice_hash(name) >> 8u) * (1.0 / 16777216.0);
  return load * sin(6.2831853 * (kFlutter_hz * time_s + turns)) * swing;
}
uint flutter_name(uvec3 stalk) { return stalk.x ^ stalk.y << 11u ^ stalk.z << 22u; }

#endif
