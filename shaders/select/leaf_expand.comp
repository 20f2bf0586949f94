#version 460
#extension GL_GOOGLE_include_directive : require

// From instances to the clusters of their lists that their cut shows, that are in view and not hidden. Clusters of large
// leaves are left to the hardware. kTogether: a group takes one list after the other, its clusters side by side. Otherwise an invocation
// takes a short list, and a subgroup together a long one.
// reads     view, instances, plants, cuts, items and the round's items stage, tiles; lists, clusters and lives by address
// writes    work_items, the round's work, splats and tiles stages; leaf_commands, draw_counts, counters
// dispatch  indirect, from the round's items stage; recorded by coppice::gpu::LeafRaster::record

#include "bindings.glsl"
#include "raster.glsl"
#include "shading.glsl"
#include "wind.glsl"
#include "counters.glsl"
#include "draw_commands.glsl"
#include "occlusion.glsl"
#include "raster_lists.glsl"

layout(local_size_x_id = 1) in;
layout(constant_id = 0) const uint kTogether = 0;

// An item of more clusters is a whole subgroup's.
const uint kOwnClusters = 8;

bool is_mesh(uint item) { return list_of(item) >= kMeshLists; }
uint list_count(Plant plant, uint item) { return is_mesh(item) ? plant.mesh_list_count : 1; }
uint cluster_count(uint item, Plant plant, ClusterList list) {
  return list_of(item) == kPageList ? page_cluster_count(cut_leaf_count(slot_of(item), plant)) : list.cluster_count;
}
uint cluster_count(uint item) {
  Plant plant = plants[plant_at(slot_of(item))];
  return is_mesh(item) ? plant.mesh_cluster_count : cluster_count(item, plant, list_at(plant, list_of(item)));
}

// False where the plant has no command left.
bool draw_by_hardware(uint plant_index, uint item, uint cluster, ShownLeaves shown) {
  Plant plant = plants[plant_index];
  uint place = take_commands(kDrawCounts * plant_index + kClusterCount, 1, plant.leaf_command_capacity);
  if (place == plant.leaf_command_capacity) return false;
  leaf_commands[plant.leaf_command_base + plant.instance_count + place] = cluster_command(item, cluster, shown.count);
  return true;
}

// Every step-th cluster of a list. What of them is drawn: leaves or triangles, by the hardware of them.
uvec2 expand_list(uint item, Instance instance, uint first, uint step) {
  Plant plant = plants[instance.plant];
  ClusterList list = list_at(plant, list_of(item));
  bool quads = list_of(item) < kWoodLists, paged = list_of(item) == kPageList;
  uint leaf_count = item_leaf_count(item, plant, list), count = cluster_count(item, plant, list);
  float split_px = hardware_leaf_px(view.error_px * exp2(lod_bias_of(instance)));
  float merged = quads ? merged_share(plant, leaf_count) : 0.0;
  float reach_m = wind_reach_m(instance);
  float object_px = instance.scale * view.focal_px;  // times distance in m: of a metre in object space
  uvec2 drawn = uvec2(0);
  for (uint i = first; i < count; i += step) {
    Cluster cluster = cluster_at(list, i);
    vec3 center = world_from_object(instance, cluster.center);
    float radius_m = instance.scale * cluster.radius_m + reach_m;
    ShownLeaves shown = all_shown(cluster);
    if (paged) shown = shown_of_page(cluster, i, leaf_count);
    bool seen = shown.count > 0 && sphere_in_view(center, radius_m);
    if (seen) seen = !occluded(center, radius_m);
    float nearest_m = max(size_distance_m(center) - radius_m, view.near_m);
    uint quarter = shown_quarter(shown);
    // Discs leave gaps in a surface unless they are about a pixel.
    float splat_px = is_surface(cluster) ? min(push.splat_px, 1.5) : push.splat_px;
    bool small = unpack_length(cluster.grains_m, quarter) * object_px < splat_px * nearest_m;
    bool large = seen && quads && unpack_length(cluster.leaf_sizes_m, quarter) * object_px > split_px * nearest_m;
    if (large) large = draw_by_hardware(instance.plant, item, i, shown);
    bool rasterised = seen && !large;
    float sun = rasterised ? sun_past_others(instance, plant, center) : 0.0;
    WorkItem work = work_item(item, work_of(i, shown, merged), cluster, sun);
    append_work(kSplatWork, rasterised && small, work);
    append_work(kLeafWork, rasterised && !small, work);
    uint leaves = paged ? drawn_count(shown, cluster, born_splits(leaf_count, i)) : shown.count;
    if (seen) drawn += uvec2(leaves, large ? leaves : 0);
  }
  return drawn;
}

// What is drawn: leaves, triangles of leaf meshes and of wood, and of all that triangles by the hardware.
uvec4 expand(uint item, uint first, uint step) {
  Instance instance = instance_at(slot_of(item));
  uvec2 drawn = uvec2(0);
  for (uint i = 0; i < list_count(plants[instance.plant], item); ++i) drawn += expand_list(item + (i << kSlotBits), instance, first, step);
  uint kind = list_of(item) < kWoodLists ? 0 : is_mesh(item) ? 1 : 2;
  uvec4 sum = uvec4(0, 0, 0, 2 * drawn.y);
  sum[kind] = drawn.x;
  return sum;
}

void add_to_counters(uvec4 sum) {
  COPPICE_COUNT(leaves, sum.x)
  COPPICE_COUNT(leaf_mesh_triangles, sum.y)
  COPPICE_COUNT(wood_triangles, sum.z)
  COPPICE_COUNT(hardware_triangles, sum.w)
}

shared uint group_sum[4];

void expand_together(uint count) {
  if (gl_LocalInvocationIndex < 4) group_sum[gl_LocalInvocationIndex] = 0;
  barrier();
  uvec4 sum = uvec4(0);
  for (uint i = gl_WorkGroupID.x; i < count; i += gl_NumWorkGroups.x) sum += expand(items[i], gl_LocalInvocationIndex, gl_WorkGroupSize.x);
  for (uint i = 0; i < 4; ++i)
    if (sum[i] > 0) atomicAdd(group_sum[i], sum[i]);
  barrier();
  if (gl_LocalInvocationIndex == 0) add_to_counters(uvec4(group_sum[0], group_sum[1], group_sum[2], group_sum[3]));
}

void expand_each(uint count) {
  uvec4 all = subgroupBallot(true), sum = uvec4(0);
  for (uint i = group_index() * gl_WorkGroupSize.x; i < count; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    bool some = i + gl_LocalInvocationIndex < count;
    uint item = some ? items[i + gl_LocalInvocationIndex] : 0;
    bool is_long = some && cluster_count(item) > kOwnClusters;
    // First each invocation its own short item, then one long item after the other, its clusters side by side.
    uvec4 left = subgroupBallot(is_long);
    some = some && !is_long;
    uint mine = item, first = 0, step = 1;
    bool more;
    do {
      if (some) sum += expand(mine, first, step);
      more = any(notEqual(left, uvec4(0)));
      uint owner = more ? subgroupBallotFindLSB(left) : 0;
      left[owner >> 5] &= ~(1u << (owner & 31u));
      mine = subgroupBroadcast(item, owner);
      some = true;
      first = subgroupBallotExclusiveBitCount(all);
      step = subgroupBallotBitCount(all);
    } while (more);
  }
  add_to_counters(sum);
}

void main() {
  uint count = rounds[push.round].items.count;
  if (kTogether != 0) expand_together(count);
  else expand_each(count);
}
