#version 460
#extension GL_GOOGLE_include_directive : require

// From instances to the clusters of their lists that are in view and not hidden by earlier rounds; one invocation per instance and list.
// reads     view, instances, items, lists, tiles; clusters by address
// writes    work_items and splat_items, and the round's work and splats stages; counters
// dispatch  indirect, from the round's items stage; recorded by coppice::gpu::LeafRaster::record

#include "bindings.glsl"
#include "raster.glsl"

layout(local_size_x_id = 1) in;

layout(set = 0, binding = 9, scalar) buffer CounterBuffer { Counters counters; };

void add_count(uint word, uint value) {
  if (word == 0) {
    if (atomicAdd(counters.leaves[0], value) > 0xffffffffu - value) atomicAdd(counters.leaves[1], 1);
  } else {
    if (atomicAdd(counters.wood_triangles[0], value) > 0xffffffffu - value) atomicAdd(counters.wood_triangles[1], 1);
  }
}

void append_leaves(bool some, uint item, uint cluster) {
  uvec4 which = subgroupBallot(some);
  uint count = subgroupBallotBitCount(which);
  if (count == 0) return;
  uint first = 0;
  if (subgroupElect()) {
    first = atomicAdd(rounds[push.round].work.count, count);
    atomicMax(rounds[push.round].work.groups[0], min((min(first + count, push.work_capacity) - 1) / kWorkPerGroup + 1, kMaxDispatchGroups));
    if (first == 0) wake_tiles();
  }
  uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(which);
  if (some && place < push.work_capacity) work_items[place] = uvec2(item, cluster);
}

void expand(uint item) {
  uint slot = slot_of(item);
  Instance instance = instances[slot];
  RasterList list = lists[instance.plant * kRasterLists + list_of(item)];
  // Discs leave gaps in a surface unless they are about a pixel.
  float splat_px = list_of(item) < kRasterLevels ? push.splat_px : min(push.splat_px, 1.5);
  uint drawn = 0;
  for (uint i = 0; i < list.cluster_count; ++i) {
    RasterCluster cluster = RasterClusterArray(list.clusters).at[i];
    vec3 center = world_from_object(instance, cluster.center);
    float radius_m = instance.scale * cluster.radius_m;
    bool seen = sphere_in_view(center, radius_m);
    if (seen && push.round > 0) seen = !occluded(center, radius_m);
    float nearest_m = max(distance(center, view.camera_position) - radius_m, view.near_m);
    bool small = cluster.grain_m * instance.scale * view.focal_px < splat_px * nearest_m;
    append_splats(seen && small, item, i);
    append_leaves(seen && !small, item, i);
    if (seen) drawn += cluster.leaf_count;
  }
  if (drawn > 0) add_count(list_of(item) < kRasterLevels ? 0 : 1, drawn);
}

void main() {
  uint count = rounds[push.round].items.count;
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) expand(items[i]);
}
