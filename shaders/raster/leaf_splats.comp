#version 460
#extension GL_GOOGLE_include_directive : require

// Leaves and wood triangles of few pixels: each is drawn as some discs of its projected area, at one depth.
// reads     view, instances, plants, cuts, work_items and the splats stages, picture; lists, clusters, splats and lives by address
// writes    picture
// dispatch  indirect, from the pass's splats stage, y: eyes; recorded by coppice::gpu::LeafRaster::record_leaves
//
// kClusterLanes invocations process a cluster. Software drivers load the data that a cluster's splats share once for every invocation, as
// many loads as the splats themselves, and are fastest with one invocation. Other devices merge loads of neighbours, so neighbours should
// be neighbours in memory.

#include "bindings.glsl"
#include "raster_place.glsl"
#include "write_pixel.glsl"

layout(local_size_x_id = 1) in;
layout(constant_id = 3) const uint kClusterLanes = 1;

// first: first_pixel; along: position on the leaf's axis, in half lengths, times Cluster::axis_steps; size_px: of a splat of size 1, times
// w
void raster_splat(uint first, Placed placed, uint name, Splat splat, float along, float size_px, bool shown) {
  vec3 q = vec3(splat.xy & 0xffffu, splat.xy >> 16, splat.z_size & 0xffffu);
  if (along != 0.0) q += along * unpackSnorm4x8(splat.axis).xyz;
  vec4 at = projected(placed, q);
  float inverse_w = 1.0 / at.z;
  vec3 face = unfold(unpackSnorm4x8(splat.normals).zw);
  // Radius of a disc of the same area; a tilted leaf looks narrower.
  float radius_px =
      inversesqrt(3.14159265) * size_px * float(splat.z_size >> 16) * inverse_w * sqrt(max(abs(dot(face, placed.eye)), 0.02));
  vec2 middle = at.xy * inverse_w;
  vec2 size = vec2(push.width_px, push.height_px);
  ivec2 low = max(ivec2(ceil(clamp(middle - radius_px, vec2(0.0), size) - 0.5)), ivec2(0));  // NaN becomes 0 too
  ivec2 high = min(ivec2(ceil(clamp(middle + radius_px, vec2(0.0), size) - 0.5)), ivec2(size));
  float key = at.w * inverse_w;
  bool seen = shown && at.z > 0.0 && is_between_planes(key) && low.x < high.x && low.y < high.y;
  // The loop ends at the bottom, so that no iteration is in vain.
  ivec2 pixel = low;
  bool more = seen;
  do {
    vec2 off = vec2(pixel) + 0.5 - middle;
    if (more && dot(off, off) < radius_px * radius_px) write_pixel(first + uint(pixel.y) * push.width_px + uint(pixel.x), key, name);
    ++pixel.x;
    if (pixel.x >= high.x) pixel = ivec2(low.x, pixel.y + 1);
    more = seen && pixel.y < high.y;
  } while (more);
}

void raster_cluster(uint eye, uint place_of_work, uint lane) {
  WorkItem work = work_at(place_of_work);
  Instance instance = instance_at(slot_of(work.item));
  Plant plant = plants[plant_of(instance)];
  ClusterList list = list_at(plant, list_of(work.item));
  uint index = cluster_of_work(work.work);
  Cluster cluster = cluster_at(list, index);
  ShownLeaves shown = shown_of_work(work.work);
  uint splits = born_splits(item_leaf_count(work.item, plant, list), index);
  Placed placed = place(eye, place_of_work, work, instance, list.box_min, list.splat_step, cluster);
  // Discs of few pixels become smaller if only a share of the leaves is drawn.
  float side = placed.wood ? 1.0 : sqrt(placed.leaves);
  float size_px = side * cluster.splat_size_m / 65535.0 * instance.scale * view.focal_px;
  uint first = first_pixel(eye), grains = log2_grains(cluster), count = shown.count << grains, disc = lane;
  SplatArray splats = SplatArray(cluster.splats);
  do {
    uint leaf = min(disc, count - 1) >> grains;
    float along = float(2 * (disc - (leaf << grains)) + 1) / float(1u << grains) - 1.0;
    bool born = true;
    if (shown.partly_born) born = is_born(LeafArray(cluster.leaves).at[leaf].life, splits);
    if (kClusterLanes == 1 || disc < count)
      raster_splat(first, placed, name_of_leaf(placed.first_name, leaf, push.place_bits), splats.at[leaf],
                   along * cluster.axis_steps, size_px, born);
    disc += kClusterLanes;
  } while (disc < count);
}

void main() {
  uint earlier = earlier_work(kSplatWork), count = work_count(kSplatWork, earlier);
  uint step = gl_NumWorkGroups.x * gl_WorkGroupSize.x / kClusterLanes;
  for (uint i = (group_index() * gl_WorkGroupSize.x + gl_LocalInvocationIndex) / kClusterLanes; i < count; i += step)
    raster_cluster(gl_WorkGroupID.y, work_place(kSplatWork, earlier + i), gl_LocalInvocationIndex % kClusterLanes);
}
