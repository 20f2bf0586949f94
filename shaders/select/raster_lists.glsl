// The rasteriser's lists of a culling pass, and how shaders append to them. After raster.glsl.
// One atomic reserves places for all invocations of a subgroup: with one for each invocation, cores would wait for each other.

const uint kNoItem = 0xffffffffu;

// Number of groups for `count` elements if a group takes at_a_time.
uint groups_for(uint count, uint at_a_time) { return min((count - 1) / at_a_time + 1, kMaxDispatchGroups); }

void append_item(uint item) {
  uvec4 which = subgroupBallot(item != kNoItem);
  uint count = subgroupBallotBitCount(which), first = 0;
  if (count == 0) return;
  if (subgroupElect()) {
    first = atomicAdd(culling_passes[push.culling_pass].items.count, count);
    atomicMax(culling_passes[push.culling_pass].items.groups[0], groups_for(first + count, push.expand_items));
  }
  uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(which);
  if (item != kNoItem) items[place] = item;
}

// Marks that the pass draws something, so that its tiles must be computed.
void wake_tiles() {
  uvec3 finest = tile_level(0);
  uint finest_count = finest.x * finest.y;
  culling_passes[push.culling_pass].finest_tiles.groups[0] = (finest_count + push.lanes - 1) / push.lanes;
  culling_passes[push.culling_pass].other_tiles.groups[0] = (tile_count() - finest_count + push.lanes - 1) / push.lanes;
}

// Returns the first of `count` new places of a list in the pass. They may lie beyond the capacity.
uint take_places(uint list, uint count) {
  uint first;
  if (list == kLeafWork) {
    first = atomicAdd(culling_passes[push.culling_pass].work.count, count);
    atomicMax(culling_passes[push.culling_pass].work.groups[0], groups_for(min(first + count, push.work_capacity), push.leaf_clusters));
  } else {
    first = atomicAdd(culling_passes[push.culling_pass].splats.count, count);
    atomicMax(culling_passes[push.culling_pass].splats.groups[0], groups_for(min(first + count, push.work_capacity), push.splat_clusters));
  }
  if (first == 0) wake_tiles();
  return first + earlier_work(list);
}

// some: true if this invocation appends
void append_work(uint list, bool some, WorkItem work) {
  uvec4 which = subgroupBallot(some);
  uint count = subgroupBallotBitCount(which), first = 0;
  if (count == 0) return;
  if (subgroupElect()) first = take_places(list, count);
  uint index = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(which);
  if (some && index < push.work_capacity) work_items[work_place(list, index)] = work;
}

// The hardware draws clusters whose leaves are larger on average, px, because it shows their texture; in shadow maps it draws none. A
// threshold that an instance's bias raises enlarges leaves everywhere; those of far plants have no visible texture.
float hardware_leaf_px(float error_px) {
  const float kThresholds = 6.0, kMaxFactor = 4.0;
  return view.is_shadow != 0 ? 1e9 : clamp(kThresholds * error_px, push.split_px, kMaxFactor * push.split_px);
}
