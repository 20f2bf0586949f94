#version 460
#extension GL_GOOGLE_include_directive : require

// Turns instances into the clusters of their lists that their cut shows, that are in view and not hidden. Clusters of large leaves are left
// to the hardware. With kTogether a group processes one list after the other, its clusters side by side. Otherwise an invocation processes
// a short list, and a subgroup together a long one.
// reads     view, instances, plants, cuts, items and the pass's items stage, tiles; lists, clusters and lives by address
// writes    work_items, the pass's work, splats and tiles stages; leaf_commands, draw_counts, counters
// dispatch  indirect, from the pass's items stage; recorded by coppice::gpu::LeafRaster::record

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

// An item of more clusters is processed by a whole subgroup.
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

// False if the plant has no command left.
bool draw_by_hardware(uint plant_index, uint item, uint cluster, ShownLeaves shown) {
  Plant plant = plants[plant_index];
  uint place = take_commands(kDrawCounts * plant_index + kClusterCount, 1, plant.leaf_command_capacity);
  if (place >= plant.leaf_command_capacity) return false;
  leaf_commands[plant.leaf_command_base + plant.instance_count + place] = cluster_command(item, cluster, shown.count);
  return true;
}

// A cluster that is to be drawn.
struct Found {
  bool splats, leaves;  // the list of work that it goes to; neither: the hardware draws it, or it is not visible
  WorkItem work;
  uvec2 drawn;  // leaves or triangles; those by the hardware
};

// Shared by all clusters of a list.
struct Expanded {
  uint item;
  Instance instance;
  Plant plant;
  ClusterList list;
  uint leaf_count;
  float split_px, reach_m;
  float object_px;  // divided by the distance in m: the size of a metre in object space
};

Found find(Expanded from, uint i) {
  bool quads = list_of(from.item) < kWoodLists, paged = list_of(from.item) == kPageList;
  Cluster cluster = cluster_at(from.list, i);
  vec3 center = world_from_object(from.instance, cluster.center);
  float radius_m = from.instance.scale * cluster.radius_m + from.reach_m;
  ShownLeaves shown = all_shown(cluster);
  if (paged) shown = shown_of_page(cluster, i, from.leaf_count);
  bool seen = shown.count > 0 && sphere_in_view(center, radius_m);
  if (seen) seen = !occluded(center, radius_m);
  float nearest_m = max(size_distance_m(center) - radius_m, view.near_m);
  uint quarter = shown_quarter(shown);
  // Discs leave gaps, in which a surface would show what is behind it.
  bool small = !is_surface(cluster) && unpack_length(cluster.grains_m, quarter) * from.object_px < push.splat_px * nearest_m;
  bool large = seen && quads && unpack_length(cluster.leaf_sizes_m, quarter) * from.object_px > from.split_px * nearest_m;
  if (large) large = draw_by_hardware(plant_of(from.instance), from.item, i, shown);
  bool rasterised = seen && !large;
  float sun = rasterised ? sun_past_others(from.instance, from.plant, center) : 0.0;
  uint leaves = paged ? drawn_count(shown, cluster, born_splits(from.leaf_count, i)) : shown.count;
  return Found(rasterised && small, rasterised && !small, work_item(from.item, work_of(i, shown), cluster, sun),
               seen ? uvec2(leaves, large ? leaves : 0) : uvec2(0));
}

// All invocations of a subgroup run loops whose bodies append together as often as the one with most to do.
bool for_some(bool more) { return any(notEqual(subgroupBallot(more), uvec4(0))); }

// Expands every step-th cluster of a list, or none if `some` is false. Returns what is drawn: leaves or triangles; those by the hardware.
uvec2 expand_list(bool some, uint item, Instance instance, uint first, uint step) {
  Expanded from;
  from.item = item;
  from.instance = instance;
  uint count = 0;
  if (some) {
    from.plant = plants[plant_of(instance)];
    from.list = list_at(from.plant, list_of(item));
    from.leaf_count = item_leaf_count(item, from.plant, from.list);
    from.split_px = hardware_leaf_px(view.error_px * exp2(lod_bias_of(instance)));
    from.reach_m = wind_reach_m(instance);
    from.object_px = instance.scale * view.focal_px;
    count = min(cluster_count(item, from.plant, from.list), kMaxListClusters);
  }
  uvec2 drawn = uvec2(0);
  for (uint i = first; for_some(i < count); i += step) {
    Found found = Found(false, false, WorkItem(0, 0, uvec2(0)), uvec2(0));
    if (i < count) found = find(from, i);
    append_work(kSplatWork, found.splats, found.work);
    append_work(kLeafWork, found.leaves, found.work);
    drawn += found.drawn;
  }
  return drawn;
}

// Returns what is drawn: leaves, triangles of leaf meshes and of wood, and the triangles by the hardware among all of them.
uvec4 expand(bool some, uint item, uint first, uint step) {
  Instance instance = instance_at(slot_of(item));
  uint lists = some ? min(list_count(plants[plant_of(instance)], item), kMaxLeafMeshes) : 0;
  uvec2 drawn = uvec2(0);
  for (uint i = 0; for_some(i < lists); ++i) drawn += expand_list(i < lists, item + (i << kSlotBits), instance, first, step);
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
  for (uint i = gl_WorkGroupID.x; i < count; i += gl_NumWorkGroups.x) sum += expand(true, items[i], gl_LocalInvocationIndex, gl_WorkGroupSize.x);
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
    // First each invocation expands its own short item, then the subgroup one long item after the other, its clusters side by side.
    uvec4 left = subgroupBallot(is_long);
    some = some && !is_long;
    uint mine = item, first = 0, step = 1;
    bool more;
    do {
      sum += expand(some, mine, first, step);
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
  uint count = min(culling_passes[push.culling_pass].items.count, uint(items.length()));
  if (kTogether != 0) expand_together(count);
  else expand_each(count);
}
