// Descriptor set 1 of the compute rasteriser, as gpu/leaf_raster.cpp writes it, and what its passes share. After bindings.glsl.
// A pixel of the picture is two words: the leaf's radiance, then its depth key; 0 where there is no leaf. Taken as one 64-bit number, the
// larger one is the nearer leaf.

#extension GL_KHR_shader_subgroup_ballot : require

#include "raster_shared.h"
#include "clusters.glsl"

layout(set = 1, binding = 0, scalar) buffer PictureBuffer { uint picture[]; };
layout(set = 1, binding = 1, scalar) readonly buffer BlockBuffer { InstanceBlock blocks[]; };
layout(set = 1, binding = 2, scalar) buffer RoundBuffer { RasterRound rounds[]; };
layout(set = 1, binding = 3, scalar) buffer VisibleBlockBuffer { uint visible_blocks[]; };
layout(set = 1, binding = 4, scalar) buffer ItemBuffer { uint items[]; };        // as slot_of and list_of take them; from the end: HardwareDraws of all rounds
layout(set = 1, binding = 5, scalar) buffer WorkBuffer { uvec2 work_items[]; };  // the same, work_of
layout(set = 1, binding = 6, scalar) buffer BigBuffer { uvec2 big_items[]; };    // the same, cluster and leaf: kClusterLeaves of each
layout(set = 1, binding = 7, scalar) buffer SplatBuffer { uvec2 splat_items[]; };  // as work_items
layout(set = 1, binding = 8, scalar) buffer TileBuffer { uint tiles[]; };       // the smallest key of each tile, level by level

// The picture's words again, to be read without atomics: software drivers load a vector from texels, but word by word from buffers.
layout(set = 1, binding = 9) uniform usamplerBuffer picture_words;

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CardLookArray { CardLook at[]; };

layout(push_constant, scalar) uniform Push { RasterPush push; };

// The list that an item of the instance names.
ClusterList list_for(Instance instance, uint item) { return list_at(plants[instance.plant], list_of(item)); }

// A cluster of an item's list and what is shown of it, one leaf at least, in a word.
const uint kWorkClusterBits = 24;
uint work_of(uint cluster, ShownLeaves shown) {
  return cluster | (shown.count - 1) << kWorkClusterBits | (shown.partly_born ? 1u << 31 : 0u);
}
uint cluster_of_work(uint work) { return work & ((1u << kWorkClusterBits) - 1u); }
ShownLeaves shown_of_work(uint work) { return ShownLeaves((work >> kWorkClusterBits & (kClusterLeaves - 1u)) + 1, work >> 31 != 0); }

// The leaves of the cut that an item is of: those of its list, or of the instance's cut.
uint item_leaf_count(uint item, Plant plant, ClusterList list) {
  return list_of(item) == kPageList ? cut_leaf_count(slot_of(item), plant) : list.leaf_count;
}

// x: columns, y: rows, z: place of the level's first tile.
uvec3 tile_level(uint level) {
  uint first = 0;
  uvec2 size = uvec2(0);
  for (uint i = 0; i <= level; ++i) {
    first += size.x * size.y;
    uint shift = kTileShift + 2 * i;
    size = (uvec2(push.width_px, push.height_px) + (1u << shift) - 1) >> shift;
  }
  return uvec3(size, first);
}

// The round draws something, so that its tiles are worth a look.
void wake_tiles() {
  uvec3 finest = tile_level(0), last = tile_level(kTileLevels - 1);
  uint finest_count = finest.x * finest.y;
  rounds[push.round].finest_tiles.groups[0] = (finest_count + push.lanes - 1) / push.lanes;
  rounds[push.round].other_tiles.groups[0] = (last.z + last.x * last.y - finest_count + push.lanes - 1) / push.lanes;
}

// Appending: an atomic takes places for all invocations of a subgroup that have something. One each, and cores wait for each other.
// some: whether this invocation has
void append_splats(bool some, uint item, uint work) {
  uvec4 which = subgroupBallot(some);
  uint count = subgroupBallotBitCount(which);
  if (count == 0) return;
  uint first = 0;
  if (subgroupElect()) {
    first = atomicAdd(rounds[push.round].splats.count, count);
    uint end = min(first + count, push.work_capacity);
    atomicMax(rounds[push.round].splats.groups[0], min((end - 1) / push.splat_clusters + 1, kMaxDispatchGroups));
    if (first == 0) wake_tiles();
  }
  uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(which);
  if (some && place < push.work_capacity) splat_items[place] = uvec2(item, work);
}

// A number for each group. Software drivers give each core one stretch of groups after the other: this way all of them get some of every
// part of a list, whose beginning is often the larger work.
uint group_index() {
  uint half_count = (gl_NumWorkGroups.x + 1) / 2;
  return gl_WorkGroupID.x < half_count ? 2 * gl_WorkGroupID.x : 2 * (gl_WorkGroupID.x - half_count) + 1;
}

float depth_key(float inverse_w) { return max(push.key_a + push.key_b * inverse_w, 1e-30); }

// Clusters whose leaves are larger on average, px, are drawn by the hardware, which shows their texture; in a shadow map none. A raised
// threshold makes leaves larger everywhere; those of far plants have no texture to show for it.
float hardware_leaf_px() {
  const float kThresholds = 6.0, kMostFactor = 4.0;
  return view.is_shadow != 0 ? 1e9 : clamp(kThresholds * view.error_px, push.split_px, kMostFactor * push.split_px);
}

// (x * w, y * w, w) of a point in px, and of a direction.
vec3 screen_point(vec3 world) {
  vec4 clip = view.clip_from_world * vec4(world, 1.0);
  return vec3(0.5 * vec2(push.width_px, push.height_px) * (clip.xy + clip.w), clip.w);
}
vec3 screen_direction(vec3 world) {
  vec4 clip = view.clip_from_world * vec4(world, 0.0);
  return vec3(0.5 * vec2(push.width_px, push.height_px) * (clip.xy + clip.w), clip.w);
}

// Whether earlier rounds hide a sphere: all tiles it may touch are covered nearer than its nearest point. False for what is large.
bool occluded(vec3 center, float radius_m) {
  vec3 middle = screen_point(center);
  float nearest = middle.z - radius_m;
  if (nearest <= view.near_m) return false;
  // An ellipse on the screen: its long axis grows with the angle to the view's axis.
  vec2 at = middle.xy / middle.z;
  vec2 off = (at - 0.5 * vec2(push.width_px, push.height_px)) / view.focal_px;
  float reach_px = radius_m * view.focal_px / nearest * sqrt(1.0 + dot(off, off)) + 1.0;
  uint level = 0;
  while (level + 1 < kTileLevels && 2.0 * reach_px > float(kTileSide_px << (2 * level))) ++level;
  float side_px = float(kTileSide_px << (2 * level));
  if (2.0 * reach_px > side_px) return false;
  uvec3 tile = tile_level(level);
  ivec2 last = ivec2(tile.xy) - 1;
  ivec2 low = clamp(ivec2(floor((at - reach_px) / side_px)), ivec2(0), last);
  ivec2 high = clamp(ivec2(floor((at + reach_px) / side_px)), ivec2(0), last);
  uint farthest = min(min(tiles[tile.z + low.y * tile.x + low.x], tiles[tile.z + low.y * tile.x + high.x]),
                      min(tiles[tile.z + high.y * tile.x + low.x], tiles[tile.z + high.y * tile.x + high.x]));
  return floatBitsToUint(depth_key(1.0 / nearest)) < farthest;
}
