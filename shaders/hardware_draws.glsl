// What the hardware draws of an instance, as draw commands and places in the wood lists. After bindings.glsl with COPPICE_CULL_ACCESS,
// clusters.glsl and counters.glsl.

#include "cluster_command.glsl"

layout(set = 0, binding = 6, scalar) writeonly buffer LeafCommandBuffer { DrawCommand leaf_commands[]; };
layout(set = 0, binding = 7, scalar) buffer DrawCountBuffer { uint draw_counts[]; };
layout(set = 0, binding = 8, scalar) buffer WoodCommandBuffer { DrawCommand wood_commands[]; };

const uint kDrawsNoLeaves = 0;
const uint kDrawsQuads = 1;
const uint kDrawsMeshes = 2;

struct HardwareDraws {
  uint slot;
  uint leaves;    // kDrawsNoLeaves, or what of them
  uint wood_lod;  // kMaxWoodLods: no wood
};

// As a word of the rasteriser's items. Slots have 24 bits there.
uint packed(HardwareDraws draws) { return draws.slot | draws.leaves << 24 | draws.wood_lod << 26; }
HardwareDraws unpacked(uint word) { return HardwareDraws(word & 0xffffffu, word >> 24 & 3u, word >> 26); }

// Commands for all clusters of the pages that may show some of the cut. False where the plant has not as many left.
bool draw_pages(Plant plant, uint plant_index, uint slot, uint leaf_count) {
  ClusterList list = list_at(plant, kPageList);
  uint count = page_cluster_count(leaf_count);
  uint first = atomicAdd(draw_counts[kDrawCounts * plant_index + 1], count), end = min(first + count, plant.leaf_command_capacity);
  bool fits = first + count <= plant.leaf_command_capacity;
  // The count must not pass what the device draws at once; what took a place below the capacity keeps it, empty where it is not enough.
  if (!fits) atomicMin(draw_counts[kDrawCounts * plant_index + 1], plant.leaf_command_capacity);
  Instance instance = instances[slot];
  uint item = slot | kPageList << kSlotBits;
  for (uint i = 0; first + i < end; ++i) {
    Cluster cluster = cluster_at(list, i);
    ShownLeaves shown = shown_of_page(cluster, i, leaf_count);
    bool seen = fits && sphere_in_view(world_from_object(instance, cluster.center), instance.scale * cluster.radius_m);
    leaf_commands[plant.leaf_command_base + plant.instance_count + first + i] = cluster_command(item, i, seen ? shown.count : 0);
  }
  return fits;
}

// Where commands are short the cut becomes coarser; a ready one has a command in any case. How many leaves are drawn.
uint draw_leaves(Plant plant, uint plant_index, uint slot, uint leaf_count) {
  for (; leaf_count > kReadyLeaves; leaf_count = max(leaf_count / 4, kReadyLeaves)) {
    cuts[slot] = min(cuts[slot], float(leaf_count));
    if (draw_pages(plant, plant_index, slot, leaf_count)) return leaf_count;
  }
  uint cut = ready_cut(leaf_count), count = list_at(plant, cut).leaf_count;
  leaf_commands[plant.leaf_command_base + atomicAdd(draw_counts[kDrawCounts * plant_index], 1)] = cluster_command(slot | cut << kSlotBits, 0, count);
  return count;
}

// From `at` on the first cluster of a mesh that is in view, or that is not; list.range_count where there is none.
uint find_cluster(ClusterList list, Instance instance, uint at, bool in_view) {
  for (; at < list.range_count; ++at) {
    Cluster cluster = cluster_at(list, at);
    if (sphere_in_view(world_from_object(instance, cluster.center), instance.scale * cluster.radius_m) == in_view) break;
  }
  return at;
}

// Runs of clusters that are in view, the last of them with all that follow. first: the instance's commands. How many triangles they draw
uint draw_runs(Plant plant, uint slot, uint mesh, uint first) {
  Instance instance = instances[slot];
  ClusterList list = list_at(plant, kWoodLists + mesh);
  uint end = 0, triangles = 0;
  for (uint i = 0; i < kInstanceParts; ++i) {
    DrawCommand command = DrawCommand(0, 0, 0, 0, 0);
    uint start = find_cluster(list, instance, end, true);
    end = i + 1 < kInstanceParts ? find_cluster(list, instance, start, false) : list.range_count;
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

// What is smaller is drawn whole, and so is what is wholly in view.
const float kPartsFrom_px = 200.0;

bool wants_parts(Plant plant, uint slot) {
  Instance instance = instances[slot];
  vec3 center = world_from_object(instance, plant.sphere_center);
  float radius = instance.scale * plant.sphere_radius;
  float size_px = coppice_projected_size_px(distance(center, view.camera_position), radius, view.near_m, view.focal_px);
  return plant.part_capacity > 0 && size_px >= kPartsFrom_px && !sphere_in_view(center, -radius);
}

// A place among the commands for parts that a count is of; plant.part_capacity where none is left.
uint part_place(Plant plant, uint plant_index, uint slot, uint count) {
  if (!wants_parts(plant, slot)) return plant.part_capacity;
  uint at = kDrawCounts * plant_index + count, place = atomicAdd(draw_counts[at], kInstanceParts);
  if (place >= plant.part_capacity) atomicMin(draw_counts[at], plant.part_capacity);
  return min(place, plant.part_capacity);
}

// How many triangles are drawn, here and below.
uint draw_wood(Plant plant, uint plant_index, uint slot, uint lod) {
  uint part = part_place(plant, plant_index, slot, kWoodPartCounts + lod);
  if (part < plant.part_capacity) return draw_runs(plant, slot, lod, plant.part_base + lod * kPartCommands + part);
  uint place = atomicAdd(wood_commands[plant_index * kMeshCommands + lod].instance_count, 1);
  wood_list[plant.wood_list_base + lod * plant.instance_count + place] = slot;
  return plant.wood_index_counts[lod] / 3;
}

// Every chunk of the plant draws the same instances; the first one's count gives the place in their list.
uint draw_leaf_meshes(Plant plant, uint plant_index, uint slot) {
  atomicAdd(counters.leaf_mesh_instances, 1);
  uint part = part_place(plant, plant_index, slot, kMeshPartCount);
  if (part < plant.part_capacity) {
    uint triangles = 0, first = plant.part_base + plant.wood_lod_count * kPartCommands + part;
    for (uint i = 0; i < plant.leaf_mesh_count; ++i) triangles += draw_runs(plant, slot, kMaxWoodLods + i, first + i * kPartCommands);
    return triangles;
  }
  uint first = plant_index * kMeshCommands + kMaxWoodLods;
  uint place = atomicAdd(wood_commands[first].instance_count, 1);
  for (uint i = 1; i < plant.leaf_mesh_count; ++i) atomicAdd(wood_commands[first + i].instance_count, 1);
  wood_list[plant.leaf_mesh_list_base + place] = slot;
  return plant.leaf_mesh_triangles;
}

// leaf_count: of quads
void draw_instance(HardwareDraws draws, Plant plant, uint plant_index, uint leaf_count) {
  uint triangles = 0;
  if (draws.leaves == kDrawsMeshes) {
    COPPICE_COUNT(leaves, plant.leaf_count)
    triangles = draw_leaf_meshes(plant, plant_index, draws.slot);
    COPPICE_COUNT(leaf_mesh_triangles, triangles)
  } else if (draws.leaves == kDrawsQuads) {
    uint leaves = draw_leaves(plant, plant_index, draws.slot, leaf_count);
    COPPICE_COUNT(leaves, leaves)
    triangles = 2 * leaves;
  }
  if (draws.wood_lod != kMaxWoodLods) {
    uint of_wood = draw_wood(plant, plant_index, draws.slot, draws.wood_lod);
    COPPICE_COUNT(wood_triangles, of_wood)
    triangles += of_wood;
  }
  COPPICE_COUNT(hardware_triangles, triangles)
}
