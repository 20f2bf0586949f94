#version 460
#extension GL_GOOGLE_include_directive : require

// Frustum culling and cut selection where the hardware draws everything: one invocation per instance slot.
// reads     view, instances, plants, table_words; lists, clusters and lives by address
// writes    cuts of all instances; for those in view leaf_commands, draw_counts, wood_commands, wood_list, counters, and debug colours by
//           address (draw_counts, instance counts of wood_commands and counters start at zero)
// dispatch  ceil(view.instance_slot_count / kCullGroupSize) groups; recorded by coppice::gpu::ViewRecorder::record_cull

#define COPPICE_CULL_ACCESS
#include "bindings.glsl"
#include "clusters.glsl"
#include "selection.glsl"
#include "tally.glsl"
#include "mesh_draws.glsl"

layout(local_size_x = kCullGroupSize) in;

// Writes commands [first, end) for the first cluster_count clusters of the pages, which may show some of the cut; the other commands draw
// nothing.
void draw_pages(Candidate candidate, uint leaf_count, uint cluster_count, uint first, uint end) {
  Plant plant = candidate.plant;
  Instance instance = candidate.instance;
  ClusterList list = list_at(plant, kPageList);
  float reach_m = candidate.reach_m - candidate.radius_m;
  for (uint i = 0; i < min(end - first, kMaxListClusters); ++i) {
    uint shown_count = 0;
    if (i < cluster_count) {
      Cluster cluster = cluster_at(list, i);
      bool seen = sphere_in_view(world_from_object(instance, cluster.center), instance.scale * cluster.radius_m + reach_m);
      if (seen) shown_count = shown_of_page(cluster, i, leaf_count).count;
    }
    leaf_commands[plant.leaf_command_base + plant.instance_count + first + i] =
        cluster_command(candidate.slot | kPageList << kSlotBits, i, shown_count);
  }
}

// If commands are short the cut becomes coarser: the finest one, of fewer and fewer leaves, whose commands fit. A ready cut always has one.
// Returns the number of leaves that are drawn.
uint draw_leaves(Candidate candidate, uint leaf_count) {
  Plant plant = candidate.plant;
  uint slot = candidate.slot;
  if (leaf_count > kReadyLeaves) {
    uint count = page_cluster_count(leaf_count), capacity = plant.leaf_command_capacity;
    uint first = min(take_commands(kDrawCounts * plant_of(candidate.instance) + kClusterCount, count, capacity), capacity);
    uint end = min(first + count, capacity);
    for (; leaf_count > kReadyLeaves; leaf_count = max(leaf_count / 4, kReadyLeaves)) {
      count = page_cluster_count(leaf_count);
      if (count <= end - first) break;
    }
    cuts[slot] = min(cuts[slot], float(leaf_count));
    bool fits = leaf_count > kReadyLeaves;
    draw_pages(candidate, leaf_count, fits ? count : 0, first, end);
    if (fits) return leaf_count;
  }
  uint cut = ready_cut(leaf_count), count = list_at(plant, cut).leaf_count;
  uint place = atomicAdd(draw_counts[kDrawCounts * plant_of(candidate.instance) + kSingleCount], 1);
  leaf_commands[plant.leaf_command_base + place] = cluster_command(slot | cut << kSlotBits, 0, count);
  return count;
}

// True if the instance is in view.
bool cull(uint slot) {
  Instance instance = instance_at(slot);
  if (!is_candidate(instance)) return false;
  Candidate candidate = candidate_of(slot, instance);
  Plant plant = candidate.plant;
  CoppiceColumn column = coppice_column(candidate.table, candidate.size_px);
  float cut = coppice_drawn_leaf_count(candidate.table, column, candidate.threshold_px);
  Selection selection = selection_of(candidate, column, cut, has_leaf_meshes(plant) && shows_leaves(candidate));
  cuts[slot] = selection.cut;
  if (!sphere_in_view(candidate.center, candidate.reach_m)) return false;

  uint leaf_count = whole_leaf_count(selection.cut, plant);
  show_debug_color(candidate, column, Shown(false, selection.meshes, float(leaf_count), 0.0));
  uint triangles = draw_meshes(MeshDraws(slot, selection.meshes, wood_lod_of(candidate, column)), plant, plant_of(instance));
  if (!selection.meshes && shows_leaves(candidate)) {
    uint leaves = draw_leaves(candidate, leaf_count);
    COPPICE_COUNT(leaves, leaves)
    triangles += 2 * leaves;
  }
  COPPICE_COUNT(hardware_triangles, triangles)
  return true;
}

void main() {
  uint slot = gl_GlobalInvocationID.x;
  bool visible = slot < view.instance_slot_count && cull(slot);
  add_to_counters(Tally(visible ? 1 : 0, 0, 0));
}
