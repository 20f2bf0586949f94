#version 460
#extension GL_GOOGLE_include_directive : require

// Frustum culling and cut selection, one invocation per instance slot.
// reads     view, instances, plants, tables; lists by address
// writes    cuts[slot]; of visible instances also their draw commands and place in the wood lists; counters
//           (draw_counts, wood instance counts and counters start at zero)
// dispatch  ceil(view.instance_slot_count / kCullGroupSize) groups; recorded by coppice::gpu::record_cull

// COPPICE_RASTER is defined for the variant of the compute rasteriser: it looks at the blocks that leaf_blocks.comp found, one group each
// (dispatch: indirect), skips what earlier rounds hide, and names what is to be drawn of each instance: lists of the rasteriser in items,
// what the hardware draws from the end of items backwards.

#define COPPICE_CULL_ACCESS
#include "bindings.glsl"
#ifdef COPPICE_RASTER
#include "raster.glsl"
#else
#include "clusters.glsl"
#endif

#include "counters.glsl"
#include "debug_view.glsl"
#include "hardware_draws.glsl"

layout(local_size_x = kCullGroupSize) in;
layout(constant_id = 0) const uint kDebugged = 0;  // 1: with colours for view.debug_view

shared uint group_visible;
shared uint group_occluded;
shared uint group_leaves;

// Of an invocation; main() adds them up for its group.
uint visible_count = 0;
uint occluded_count = 0;
uint leaf_sum = 0;  // of instances that leaf_expand.comp does not count

#ifdef COPPICE_RASTER
// An instance of fewer thresholds across shows no wood: at 10 px a trunk is thinner than a pixel, at 40 px it is a square of 5 px or so.
const float kWoodlessThresholds = 5.0;
// Leaf meshes with holes are the hardware's from this share of what other leaves are.
const float kHoledShare = 0.6;
// The hardware draws the wood of larger instances, and of those with larger triangles, but in shadow maps: the rasteriser gives a triangle
// one colour.
const float kFacetedWood_px = 400.0;
const float kFacet_px = 8.0;

const bool kRastersLeaves = true;

// What select() wants of an invocation's instance, appended by main() for all of them together.
const uint kNothing = 0xffffffffu;
uint splat_item = kNothing, leaf_item = kNothing, wood_item = kNothing;
uint splat_work = 0;  // of splat_item

void append_item(uint item) {
  uvec4 which = subgroupBallot(item != kNothing);
  uint count = subgroupBallotBitCount(which);
  if (count == 0) return;
  uint first = 0;
  if (subgroupElect()) {
    first = atomicAdd(rounds[push.round].items.count, count);
    atomicMax(rounds[push.round].items.groups[0], min((first + count - 1) / push.expand_items + 1, kMaxDispatchGroups));
  }
  uint place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(which);
  if (item != kNothing) items[place] = item;
}

void append_items() {
  append_splats(splat_item != kNothing, splat_item, splat_work);
  append_item(leaf_item);
  append_item(wood_item);
  splat_item = leaf_item = wood_item = kNothing;
}

// Room in the round's work lists for the clusters of a list. For one of each instance there is room besides.
bool reserve(uint cluster_count) { return atomicAdd(rounds[push.round].reserved, cluster_count) + cluster_count <= kWorkClusters; }

bool is_hidden(vec3 center, float radius) { return push.round > 0 && occluded(center, radius); }

bool has_mesh_lists(Plant plant) { return plant.mesh_list_count > 0; }

// Whether the leaves of a cut, of the pages some of those that it bears last, are too small for the hardware, on average.
bool has_small_leaves(Instance instance, Plant plant, uint leaf_count, float distance_m) {
  ClusterList list = list_at(plant, list_of_cut(leaf_count));
  float leaf_size_m = list.leaf_size_m;
  if (leaf_count > kReadyLeaves) leaf_size_m = unpack_length(cluster_at(list, last_born_cluster(leaf_count)).leaf_sizes_m, 0);
  // Leaf meshes without lists have holes for an outline, of which the rasteriser's quads show the least.
  float split_px = hardware_leaf_px() * (has_mesh_lists(plant) ? 1.0 : kHoledShare);
  return leaf_size_m * instance.scale * view.focal_px <= split_px * max(distance_m, view.near_m);
}

// How many leaves are drawn: of the pages an eighth more than quads with textures need, of whose cover discs and masks of few pixels lose
// some; a ready cut has as many more, in the mean, as it is rounded up.
uint raster_leaves(Instance instance, Plant plant, uint slot, uint leaf_count, float distance_m) {
  if (leaf_count > kReadyLeaves) {
    leaf_count = min(leaf_count + leaf_count / 8, plant.resident_leaf_count);
    cuts[slot] = float(leaf_count);
    leaf_item = slot | kPageList << kSlotBits;
    if (reserve(page_cluster_count(leaf_count))) return leaf_count;
    leaf_item = kNothing;
  }
  // What is one cluster has been culled with the instance.
  uint cut = ready_cut(leaf_count), item = slot | cut << kSlotBits;
  ClusterList list = list_at(plant, cut);
  if (list.grain_m * instance.scale * view.focal_px < push.splat_px * max(distance_m, view.near_m)) {
    splat_item = item;
    splat_work = work_of(0, ShownLeaves(list.leaf_count, false));
    leaf_sum += list.leaf_count;
  } else {
    leaf_item = item;
  }
  return list.leaf_count;
}

// Whether the rasteriser takes the instance's leaf meshes.
bool raster_meshes(uint slot, Plant plant) {
  if (!has_mesh_lists(plant) || !reserve(plant.mesh_cluster_count)) return false;
  leaf_item = slot | kMeshLists << kSlotBits;
  leaf_sum += plant.leaf_count;
  atomicAdd(counters.leaf_mesh_instances, 1);
  return true;
}

// Whether the rasteriser takes the instance's wood, or leaves it out. nearest_m: to the nearest it may be
bool raster_wood(Instance instance, Plant plant, uint slot, float size_px, float nearest_m, uint wood_lod) {
  if (wood_lod == kMaxWoodLods || (plant.wood_list_mask >> wood_lod & 1u) == 0) return false;
  uint index = kWoodLists + wood_lod;
  ClusterList list = list_at(plant, index);
  float px_per_m = instance.scale * view.focal_px / max(nearest_m, view.near_m);
  if (view.is_shadow == 0 && (size_px >= kFacetedWood_px || list.facet_m * px_per_m >= kFacet_px)) return false;
  // The rasteriser knows how much of a triangle its texture covers, not where: no more than a splat shows.
  if (list.holed_m * px_per_m >= push.splat_px) return false;
  if (size_px > kWoodlessThresholds * view.error_px && reserve(list.cluster_count)) wood_item = slot | index << kSlotBits;
  return true;
}

// Few instances are: their draws are hardware_draws.comp's, as software drivers would run this for all.
void draw_by_hardware(HardwareDraws draws, Plant plant, uint leaf_count) {
  uint place = atomicAdd(rounds[0].draws.count, 1);
  atomicMax(rounds[0].draws.groups[0], min(place / push.lanes + 1, kMaxDispatchGroups));
  items[items.length() - 1 - place] = packed(draws);
}
#else
// The hardware draws everything.
const bool kRastersLeaves = false;
void draw_by_hardware(HardwareDraws draws, Plant plant, uint leaf_count) { draw_instance(draws, plant, instances[draws.slot].plant, leaf_count); }
bool is_hidden(vec3 center, float radius) { return false; }
bool has_mesh_lists(Plant plant) { return false; }
bool has_small_leaves(Instance instance, Plant plant, uint leaf_count, float distance_m) { return false; }
uint raster_leaves(Instance instance, Plant plant, uint slot, uint leaf_count, float distance_m) { return 0; }
bool raster_meshes(uint slot, Plant plant) { return false; }
bool raster_wood(Instance instance, Plant plant, uint slot, float size_px, float nearest_m, uint wood_lod) { return false; }
#endif

// kMaxWoodLods where there is none to draw.
uint wood_lod_of(Plant plant, CoppiceTable table, CoppiceColumn column, float threshold_px) {
  if (plant.wood_resident_mask == 0) return kMaxWoodLods;
  uint wanted = view.lod_full != 0 ? 0 : coppice_wood_lod(table, column, threshold_px);
  return coppice_resident_wood_lod(plant.wood_resident_mask, wanted, plant.wood_lod_count);
}

// How an instance's leaves are drawn.
struct Shown {
  bool rasterised, meshes;
  float leaf_count;
  CoppiceColumn column;
};

void show_debug_color(uint slot, Plant plant, CoppiceTable table, Shown shown) {
  vec3 color = kNotCounted;
  float doublings = max(log2(float(plant.leaf_count)), 1e-6);
  if (view.debug_view == kDebugLod) color = shown.meshes ? vec3(1.0) : ramp(log2(shown.leaf_count) / doublings);
  if (view.debug_view == kDebugPath)
    color = shown.rasterised ? vec3(0.1, 0.8, 0.1) : shown.meshes ? vec3(0.9, 0.1, 0.7) : kHardwareLeaves;
#ifdef COPPICE_RASTER
  if (view.debug_view == kDebugOcclusion && shown.rasterised) color = ramp(float(push.round) / float(kRasterRounds - 1));
#endif
  if (view.debug_view == kDebugError) {
    float error_px = shown.meshes ? 0.0 : coppice_error_px(table, shown.leaf_count, shown.column);
    color = ramp(log2(max(2.0 * error_px, 1.0)) / 6.0);
  }
  if (view.debug_view == kDebugResidency) color = ramp(1.0 - log2(float(plant.resident_leaf_count)) / doublings);
  DebugColorArray(view.debug_colors).at[slot] = packUnorm4x8(vec4(color, 1.0));
}

void select(uint slot) {
  Instance instance = instances[slot];
  if (instance.plant == kNoPlant) return;
  Plant plant = plants[instance.plant];

  vec3 center = world_from_object(instance, plant.sphere_center);
  float radius = instance.scale * plant.sphere_radius;
  CoppiceTable table = CoppiceTable(instance.plant * kTableStride, plant.error_level_count, plant.error_size_count, plant.wood_lod_count);
  float distance_m = distance(center, view.camera_position);
  float size_px = coppice_projected_size_px(distance_m, radius, view.near_m, view.focal_px);
  float threshold_px = coppice_instance_threshold_px(view.error_px, slot);

  bool in_view = sphere_in_view(center, radius);
  bool seen = in_view && !is_hidden(center, radius);
  if (in_view && !seen) ++occluded_count;
#ifdef COPPICE_RASTER
  if (!seen) return;  // the other variant says what the cut would be
#endif

  float resident = max(float(plant.resident_leaf_count), 1.0);
  CoppiceColumn column = coppice_column(table, size_px);
  float cut = coppice_drawn_leaf_count(table, column, threshold_px);
  bool has_leaves = plant.resident_leaf_count > 0;
  bool small = plant.leaf_mesh_count > 0 && has_leaves &&
               has_small_leaves(instance, plant, coppice_whole_leaf_count(min(cut, resident)), distance_m);
  // Small leaves are drawn as modelled only where there are lists of that, and none are for what they cast a shadow on.
  bool has_meshes = view.is_shadow == 0 && plant.leaf_mesh_count > 0 && (!small || has_mesh_lists(plant));
  bool meshes = has_meshes && (view.lod_full != 0 || coppice_wants_leaf_meshes(table, column, threshold_px));
  if (has_meshes && !meshes) cut = coppice_drawn_leaf_count(table, column, coppice_cut_threshold_px(table, column, threshold_px));
  if (view.lod_discrete != 0) cut = coppice_discrete_leaf_count(cut, plant.leaf_count);
  cut = view.lod_full != 0 ? resident : min(cut, resident);
  cuts[slot] = cut;
  if (!seen) return;

  ++visible_count;
  uint wood_lod = wood_lod_of(plant, table, column, threshold_px);
  uint leaf_count = cut_leaf_count(slot, plant);
  bool meshes_rasterised = meshes && small && raster_meshes(slot, plant);
  if (small && !meshes_rasterised) meshes = false;
  bool quads_rasterised = kRastersLeaves && !meshes && has_leaves;
  if (quads_rasterised) leaf_count = raster_leaves(instance, plant, slot, leaf_count, distance_m);
  bool wood_rasterised = raster_wood(instance, plant, slot, size_px, distance_m - radius, wood_lod);

  if (kDebugged != 0)
    show_debug_color(slot, plant, table, Shown(quads_rasterised || meshes_rasterised, meshes, float(leaf_count), column));
  uint leaves = meshes_rasterised || quads_rasterised || !has_leaves && !meshes ? kDrawsNoLeaves : meshes ? kDrawsMeshes : kDrawsQuads;
  uint wood = wood_rasterised ? kMaxWoodLods : wood_lod;
  if (leaves != kDrawsNoLeaves || wood != kMaxWoodLods) draw_by_hardware(HardwareDraws(slot, leaves, wood), plant, leaf_count);
}

void main() {
  if (gl_LocalInvocationIndex == 0) group_visible = group_occluded = group_leaves = 0;
  barrier();
#ifdef COPPICE_RASTER
  uint block_count = rounds[push.round].blocks.count;
  for (uint i = group_index(); i < block_count; i += gl_NumWorkGroups.x) {
    uint slot = visible_blocks[i] * kBlockSlots + gl_LocalInvocationIndex;
    if (slot < view.instance_slot_count) select(slot);
    append_items();
  }
#else
  if (gl_GlobalInvocationID.x < view.instance_slot_count) select(gl_GlobalInvocationID.x);
#endif
  atomicAdd(group_visible, visible_count);
  atomicAdd(group_occluded, occluded_count);
  atomicAdd(group_leaves, leaf_sum);
  barrier();
  if (gl_LocalInvocationIndex == 0 && group_visible > 0) atomicAdd(counters.visible_instances, group_visible);
  if (gl_LocalInvocationIndex == 0 && group_occluded > 0) atomicAdd(counters.occluded_instances, group_occluded);
  if (gl_LocalInvocationIndex == 0) COPPICE_COUNT(leaves, group_leaves)
}
