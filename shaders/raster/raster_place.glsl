// Projects an instance's list to the screen. After bindings.glsl.
// Software drivers spend most of their time on loads, so two records hold everything that a leaf is drawn with.

#include "coppice_light.h"
#include "raster.glsl"
#include "wind.glsl"

// Shared by the leaves of a cluster.
struct Placed {
  vec4 origin, x, y, z;  // on_screen of a place: origin + q.x * x + q.y * y + q.z * z, and by wind arc for each m^2 from middle_m in height
  vec4 arc;
  float middle_m, step_m;
  vec3 eye;              // direction towards the eye, object space
  float leaves;          // share of the crown's leaves that is drawn
  bool wood;
  uvec2 cards;
  uint first_name;
};

// step: object space, m, of one in q; place_of_work: its index in work_items
Placed place(uint eye, uint place_of_work, WorkItem work, Instance instance, vec3 box_min, vec3 step, Cluster cluster) {
  vec4 to_object = vec4(-instance.rotation.xyz, instance.rotation.w);
  Placed placed;
  placed.wood = list_of(work.item) >= kWoodLists && list_of(work.item) < kMeshLists;
  placed.cards = plants[plant_of(instance)].card_looks;
  // Lean and sway are linear about the cluster's middle. With few metres to a cell of the grid the error is small.
  CoppiceTable table = table_of(plant_of(instance));
  PlantWind field = plant_wind(table);
  WindGradient gradient;
  WindPlace middle = wind_place(table, field, cluster.center, gradient);
  WindNear moved = wind_near(field, middle, gradient, cluster.radius_m, sway_in(view.wind, field, instance));
  mat3 axes = mat3(1.0) + moved.grow;
  vec3 origin = cluster.center + moved.offset + axes * (box_min - cluster.center);
  placed.origin = on_screen(eye, vec4(world_from_object(instance, origin), 1.0));
  placed.x = on_screen(eye, vec4(oriented(instance.rotation, instance.scale * step.x * axes[0]), 0.0));
  placed.y = on_screen(eye, vec4(oriented(instance.rotation, instance.scale * step.y * axes[1]), 0.0));
  placed.z = on_screen(eye, vec4(oriented(instance.rotation, instance.scale * step.z * axes[2]), 0.0));
  placed.arc = on_screen(eye, vec4(oriented(instance.rotation, instance.scale * moved.arc), 0.0));
  placed.middle_m = cluster.center.y - box_min.y;
  placed.step_m = step.y;
  placed.eye = oriented(to_object, toward_eye(world_from_object(instance, cluster.center)));
  placed.leaves = leaf_share_of(instance);
  placed.first_name = first_name(place_of_work, work, push.place_bits);
  return placed;
}

vec4 projected(Placed placed, vec3 q) {
  float up_m = q.y * placed.step_m - placed.middle_m;
  return placed.origin + q.x * placed.x + q.y * placed.y + q.z * placed.z + up_m * up_m * placed.arc;
}
