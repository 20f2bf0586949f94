#version 460
#extension GL_GOOGLE_include_directive : require

// Culling by the frustum and by occlusion, and cut selection for the rasteriser: one group per block of instances that leaf_blocks.comp
// found.
// reads     view, instances, plants, table_words, visible_blocks and the pass's blocks stage, tiles; lists and clusters by address
// writes    for visible instances cuts, items, work_items, the pass's items, splats and tiles stages, pass 0's count of reserved
//           clusters and draws stage, and debug colours by address; counters
// dispatch  indirect, from the pass's blocks stage; recorded by coppice::gpu::LeafRaster::record

#define COPPICE_CULL_ACCESS
#include "bindings.glsl"
#include "raster.glsl"
#include "shading.glsl"
#include "selection.glsl"
#include "tally.glsl"
#include "mesh_draws.glsl"
#include "occlusion.glsl"
#include "raster_lists.glsl"

layout(local_size_x = kCullGroupSize) in;

// Instances smaller than this many thresholds show no wood: at 10 px a trunk is thinner than a pixel, at 40 px it is a square of 5 px or
// so.
const float kWoodlessThresholds = 5.0;
// The hardware draws leaf meshes with holes from this share of other leaves' size on.
const float kHoledShare = 0.6;
// The hardware draws the wood of larger instances, and of those with larger triangles, except in shadow maps, because the rasteriser gives
// a triangle one colour.
const float kFacetedWood_px = 400.0;
const float kFacet_px = 8.0;

// The parts of an instance that are appended to the rasteriser's lists; kNoItem for an absent part. All invocations of a subgroup append
// together.
struct Appended {
  uint splats;
  WorkItem splat_work;  // the item's work
  uint leaves, wood;
};

// Reserves places in work_items for the clusters of a list. Each instance has one place in any case.
bool reserve(uint cluster_count) { return atomicAdd(culling_passes[0].reserved, cluster_count) + cluster_count <= push.work_clusters; }

bool has_mesh_lists(Plant plant) { return plant.mesh_list_count > 0; }

// True if the leaves of a cut are too small for the hardware, on average. In pages a sample of the leaves that the cut bears last is
// tested.
bool has_small_leaves(Candidate candidate, uint leaf_count) {
  ClusterList list = list_at(candidate.plant, list_of_cut(leaf_count));
  float leaf_size_m = list.leaf_size_m;
  if (leaf_count > kReadyLeaves) leaf_size_m = unpack_length(cluster_at(list, last_born_cluster(leaf_count)).leaf_sizes_m, 0);
  // Leaf meshes without lists have holes that form their outline, which the rasteriser's quads show least.
  float split_px = hardware_leaf_px(candidate.error_px) * (has_mesh_lists(candidate.plant) ? 1.0 : kHoledShare);
  return leaf_size_m * candidate.instance.scale * view.focal_px <= split_px * max(candidate.distance_m, view.near_m);
}

// Returns the number of leaves that are drawn. From pages that is an eighth more than quads with textures need, because discs and masks of
// few pixels lose some coverage. Ready cuts are rounded up by about as much.
uint append_quads(Candidate candidate, uint leaf_count, inout Appended appended, inout Tally tally) {
  Plant plant = candidate.plant;
  if (leaf_count > kReadyLeaves) {
    leaf_count = min(leaf_count + leaf_count / 8, plant.resident_leaf_count);
    cuts[candidate.slot] = float(leaf_count);
    if (reserve(page_cluster_count(leaf_count))) {
      appended.leaves = candidate.slot | kPageList << kSlotBits;
      return leaf_count;
    }
  }
  // A list of a single cluster has been culled with the instance.
  uint cut = ready_cut(leaf_count), item = candidate.slot | cut << kSlotBits;
  ClusterList list = list_at(plant, cut);
  if (list.grain_m * candidate.instance.scale * view.focal_px < push.splat_px * max(candidate.distance_m, view.near_m)) {
    Cluster cluster = cluster_at(list, 0);
    float sun = sun_past_others(candidate.instance, plant, world_from_object(candidate.instance, cluster.center));
    uint work = work_of(0, ShownLeaves(list.leaf_count, false));
    appended.splats = item;
    appended.splat_work = work_item(item, work, cluster, sun);
    tally.leaves += list.leaf_count;
  } else {
    appended.leaves = item;
  }
  return list.leaf_count;
}

// True if the rasteriser draws the instance's leaf meshes.
bool append_meshes(Candidate candidate, inout Appended appended, inout Tally tally) {
  if (!has_mesh_lists(candidate.plant) || !reserve(candidate.plant.mesh_cluster_count)) return false;
  appended.leaves = candidate.slot | kMeshLists << kSlotBits;
  tally.leaves += candidate.plant.leaf_count;
  atomicAdd(counters.leaf_mesh_instances, 1);
  return true;
}

// True if the rasteriser draws the instance's wood, or leaves it out.
bool append_wood(Candidate candidate, uint wood_lod, inout Appended appended) {
  if (wood_lod == kMaxWoodLods || (candidate.plant.wood_list_mask >> wood_lod & 1u) == 0) return false;
  uint index = kWoodLists + wood_lod;
  ClusterList list = list_at(candidate.plant, index);
  float px_per_m = candidate.instance.scale * view.focal_px / max(candidate.distance_m - candidate.radius_m, view.near_m);
  if (view.is_shadow == 0 && (candidate.size_px >= kFacetedWood_px || list.facet_m * px_per_m >= kFacet_px)) return false;
  // The rasteriser knows how much of a triangle its texture covers, but not where: that suffices for a splat only.
  if (list.holed_m * px_per_m >= push.splat_px) return false;
  if (candidate.size_px > kWoodlessThresholds * candidate.error_px && reserve(list.cluster_count))
    appended.wood = candidate.slot | index << kSlotBits;
  return true;
}

// Few instances come here. hardware_draws.comp writes their draws, because software drivers would run that code for all instances.
void leave_to_hardware(MeshDraws draws) {
  uint place = atomicAdd(culling_passes[0].draws.count, 1);
  atomicMax(culling_passes[0].draws.groups[0], groups_for(place + 1, push.lanes));
  items[items.length() - 1 - place] = packed(draws);
}

void cull(uint slot, inout Appended appended, inout Tally tally) {
  Instance instance = instance_at(slot);
  if (!is_candidate(instance)) return;
  Candidate candidate = candidate_of(slot, instance);
  if (!sphere_in_view(candidate.center, candidate.reach_m)) return;
  if (occluded(candidate.center, candidate.reach_m)) {
    ++tally.occluded;
    return;
  }
  ++tally.visible;

  Plant plant = candidate.plant;
  CoppiceColumn column = coppice_column(candidate.table, candidate.size_px);
  float cut = coppice_drawn_leaf_count(candidate.table, column, candidate.threshold_px);
  bool leaves = shows_leaves(candidate);
  bool small = plant.leaf_mesh_count > 0 && leaves &&
               has_small_leaves(candidate, coppice_whole_leaf_count(min(cut, finest_cut(plant))));
  // Small leaves are drawn as modelled only if lists of that exist.
  Selection selection = selection_of(candidate, column, cut, leaves && has_leaf_meshes(plant) && (!small || has_mesh_lists(plant)));
  cuts[slot] = selection.cut;
  uint leaf_count = whole_leaf_count(selection.cut, plant);

  bool meshes_rasterised = selection.meshes && small && append_meshes(candidate, appended, tally);
  bool meshes = selection.meshes && (!small || meshes_rasterised);
  bool quads = !meshes && leaves;
  if (quads) leaf_count = append_quads(candidate, leaf_count, appended, tally);
  uint wood_lod = wood_lod_of(candidate, column);
  if (append_wood(candidate, wood_lod, appended)) wood_lod = kMaxWoodLods;

  float pass_share = float(push.culling_pass) / float(kCullingPasses - 1);
  show_debug_color(candidate, column, Shown(quads || meshes_rasterised, meshes, float(leaf_count), pass_share));
  bool by_hardware = meshes && !meshes_rasterised;
  if (by_hardware || wood_lod != kMaxWoodLods) leave_to_hardware(MeshDraws(slot, by_hardware, wood_lod));
}

void main() {
  Tally tally = Tally(0, 0, 0);
  uint block_count = min(culling_passes[push.culling_pass].blocks.count, uint(visible_blocks.length()));
  for (uint i = group_index(); i < block_count; i += gl_NumWorkGroups.x) {
    uint slot = visible_blocks[i] * kBlockSlots + gl_LocalInvocationIndex;
    Appended appended = Appended(kNoItem, WorkItem(0, 0, uvec2(0)), kNoItem, kNoItem);
    if (slot < view.instance_slot_count) cull(slot, appended, tally);
    append_work(kSplatWork, appended.splats != kNoItem, appended.splat_work);
    append_item(appended.leaves);
    append_item(appended.wood);
  }
  add_to_counters(tally);
}
