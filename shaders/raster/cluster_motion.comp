#version 460
#extension GL_GOOGLE_include_directive : require

// Computes the places of a frame's clusters in the frame before, after wind and motion of instances, so that raster_resolve.frag need not
// read the plant's field for each pixel.
// reads     view, instances, moved instances, plants, culling_passes, work_items; lists and clusters by address
// writes    ClusterMotion[] by address
// dispatch  kMotionGroups groups; recorded by coppice::gpu::LeafRaster::record if the view has velocity

#include "bindings.glsl"
#include "raster.glsl"
#include "wind.glsl"

layout(local_size_x_id = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer ClusterMotionArray { ClusterMotion at[]; };

ClusterMotion motion_of(WorkItem work) {
  Instance now = instance_at(slot_of(work.item)), before = instance_before(now);
  Cluster cluster = cluster_at(list_at(plants[plant_of(now)], list_of(work.item)), cluster_of_work(work.work));
  CoppiceTable table = table_of(plant_of(now));
  PlantWind field = plant_wind(table);
  WindGradient gradient;
  WindPlace middle = wind_place(table, field, cluster.center, gradient);
  WindNear moved = wind_near(field, middle, gradient, cluster.radius_m, sway_in(view.wind, field, now));
  WindNear moved_before = wind_near(field, middle, gradient, cluster.radius_m, sway_in(view.wind_before, field, before));

  mat3 at_rest = inverse(mat3(1.0) + moved.grow), axes_before = mat3(1.0) + moved_before.grow;
  vec4 to_object = vec4(-now.rotation.xyz, now.rotation.w);
  mat3 turned;
  for (int i = 0; i < 3; ++i) {
    vec3 axis = vec3(i == 0, i == 1, i == 2);
    turned[i] = oriented(before.rotation, before.scale / now.scale * (axes_before * (at_rest * oriented(to_object, axis))));
  }
  vec3 middle_before = world_from_object(before, cluster.center + moved_before.offset);
  vec3 rest = middle_before - turned * world_from_object(now, cluster.center + moved.offset);
  mat3 rows = transpose(turned);
  return ClusterMotion(vec4[3](vec4(rows[0], rest.x), vec4(rows[1], rest.y), vec4(rows[2], rest.z)));
}

void main() {
  uint splats = 0, count = 0;
  for (uint i = 0; i < kCullingPasses; ++i) {
    splats += culling_passes[i].splats.count;
    count += culling_passes[i].splats.count + culling_passes[i].work.count;
  }
  count = min(count, push.work_capacity);
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    uint place = i < splats ? work_place(kSplatWork, i) : work_place(kLeafWork, i - splats);
    ClusterMotionArray(push.motion).at[place] = motion_of(work_at(place));
  }
}
