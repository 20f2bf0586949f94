// Wood and leaf meshes of an instance, as draw commands and places in the wood lists. After bindings.glsl with COPPICE_CULL_ACCESS,
// clusters.glsl and counters.glsl.

#include "coppice_light.h"
#include "wind.glsl"
#include "draw_commands.glsl"

struct MeshDraws {
  uint slot;
  bool leaf_meshes;
  uint wood_lod;  // kMaxWoodLods: no wood
};

// A word of the rasteriser's items.
uint packed(MeshDraws draws) { return draws.slot | (draws.leaf_meshes ? 1u << kSlotBits : 0u) | draws.wood_lod << kSlotBits + 1; }
MeshDraws unpacked(uint word) {
  return MeshDraws(word & (kMaxSlots - 1u), (word >> kSlotBits & 1u) != 0, word >> kSlotBits + 1);
}

// Returns the first cluster of a mesh from `at` on that is in view, or that is not; list.range_count if there is none. reach_m:
// wind_reach_m
uint find_cluster(ClusterList list, Instance instance, float reach_m, uint at, bool in_view) {
  for (; at < min(list.range_count, kMaxListClusters); ++at) {
    Cluster cluster = cluster_at(list, at);
    if (sphere_in_view(world_from_object(instance, cluster.center), instance.scale * cluster.radius_m + reach_m) == in_view) break;
  }
  return at;
}

// Draws runs of clusters that are in view; the last run includes all that follow. Returns the number of triangles. first: the instance's
// commands
uint draw_runs(Plant plant, uint slot, uint mesh, uint first) {
  Instance instance = instance_at(slot);
  ClusterList list = list_at(plant, kWoodLists + mesh);
  float reach_m = wind_reach_m(instance);
  uint end = 0, triangles = 0;
  for (uint i = 0; i < kInstanceParts; ++i) {
    DrawCommand command = DrawCommand(0, 0, 0, 0, 0);
    uint start = find_cluster(list, instance, reach_m, end, true);
    end = i + 1 < kInstanceParts ? find_cluster(list, instance, reach_m, start, false) : list.range_count;
    if (start < end) {
      Cluster last = cluster_at(list, end - 1);
      uint from = cluster_at(list, start).last_death, count = last.last_death + leaf_count_of(last) - from;
      command = DrawCommand(3 * count, 1, 3 * from, 0, slot | kPartBit);
      triangles += count;
    }
    leaf_commands[first + i] = command;
  }
  return triangles;
}

// Smaller meshes are drawn whole, as are meshes that are entirely in view.
const float kPartsFrom_px = 200.0;

bool draws_in_parts(Plant plant, uint slot) {
  Instance instance = instance_at(slot);
  vec3 center = world_from_object(instance, plant.sphere_center);
  float radius = instance.scale * plant.sphere_radius;
  float size_px = coppice_projected_size_px(size_distance_m(center), radius, view.near_m, view.focal_px);
  return plant.part_capacity > 0 && size_px >= kPartsFrom_px && !sphere_in_view(center, -radius - wind_reach_m(instance));
}

// A place among the commands for parts that a count is of; plant.part_capacity if none is left.
uint part_place(Plant plant, uint plant_index, uint slot, uint count) {
  if (!draws_in_parts(plant, slot)) return plant.part_capacity;
  return min(take_commands(kDrawCounts * plant_index + count, kInstanceParts, plant.part_capacity), plant.part_capacity);
}

// Adds an instance to a mesh command and returns its place in the command's list.
uint add_instance(uint plant_index, uint mesh) {
  draw_counts[kDrawCounts * plant_index + kMeshDrawn + mesh] = 1;
  return atomicAdd(wood_commands[plant_index * kMeshCommands + mesh].instance_count, 1);
}

// Returns the number of triangles that are drawn, as does the next function.
uint draw_wood(Plant plant, uint plant_index, uint slot, uint lod) {
  uint part = part_place(plant, plant_index, slot, kWoodPartCounts + lod);
  if (part < plant.part_capacity) return draw_runs(plant, slot, lod, plant.part_base + lod * kPartCommands + part);
  uint place = add_instance(plant_index, lod);
  wood_list[plant.wood_list_base + lod * plant.instance_count + place] = slot;
  return plant.wood_index_counts[lod] / 3;
}

// Every chunk of the plant draws the same instances; the first one's count gives the place in their list.
uint draw_leaf_meshes(Plant plant, uint plant_index, uint slot) {
  atomicAdd(counters.leaf_mesh_instances, 1);
  uint part = part_place(plant, plant_index, slot, kMeshPartCount);
  if (part < plant.part_capacity) {
    uint triangles = 0, first = plant.part_base + plant.wood_lod_count * kPartCommands + part;
    for (uint i = 0; i < min(plant.leaf_mesh_count, kMaxLeafMeshes); ++i) triangles += draw_runs(plant, slot, kMaxWoodLods + i, first + i * kPartCommands);
    return triangles;
  }
  uint place = add_instance(plant_index, kMaxWoodLods);
  for (uint i = 1; i < min(plant.leaf_mesh_count, kMaxLeafMeshes); ++i) add_instance(plant_index, kMaxWoodLods + i);
  wood_list[plant.leaf_mesh_list_base + place] = slot;
  return plant.leaf_mesh_triangles;
}

// Returns the number of triangles that are drawn.
uint draw_meshes(MeshDraws draws, Plant plant, uint plant_index) {
  uint triangles = 0;
  if (draws.leaf_meshes) {
    COPPICE_COUNT(leaves, plant.leaf_count)
    triangles = draw_leaf_meshes(plant, plant_index, draws.slot);
    COPPICE_COUNT(leaf_mesh_triangles, triangles)
  }
  if (draws.wood_lod != kMaxWoodLods) {
    uint of_wood = draw_wood(plant, plant_index, draws.slot, draws.wood_lod);
    COPPICE_COUNT(wood_triangles, of_wood)
    triangles += of_wood;
  }
  return triangles;
}
