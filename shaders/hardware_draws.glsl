// What the hardware draws of an instance, as draw commands and places in the wood lists. After bindings.glsl with COPPICE_CULL_ACCESS,
// clusters.glsl and counters.glsl.

#include "cluster_command.glsl"

layout(set = 0, binding = 6, scalar) writeonly buffer LeafCommandBuffer { DrawCommand leaf_commands[]; };
layout(set = 0, binding = 7, scalar) buffer LeafCountBuffer { uint leaf_counts[]; };
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
  uint first = atomicAdd(leaf_counts[2 * plant_index + 1], count), end = min(first + count, plant.leaf_command_capacity);
  bool fits = first + count <= plant.leaf_command_capacity;
  // The count must not pass what the device draws at once; what took a place below the capacity keeps it, empty where it is not enough.
  if (!fits) atomicMin(leaf_counts[2 * plant_index + 1], plant.leaf_command_capacity);
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
  leaf_commands[plant.leaf_command_base + atomicAdd(leaf_counts[2 * plant_index], 1)] = cluster_command(slot | cut << kSlotBits, 0, count);
  return count;
}

void draw_wood(Plant plant, uint plant_index, uint slot, uint lod) {
  uint place = atomicAdd(wood_commands[plant_index * kMeshCommands + lod].instance_count, 1);
  wood_list[plant.wood_list_base + lod * plant.instance_count + place] = slot;
}

// Every chunk of the plant draws the same instances; the first one's count gives the place in their list.
void draw_leaf_meshes(Plant plant, uint plant_index, uint slot) {
  uint first = plant_index * kMeshCommands + kMaxWoodLods;
  uint place = atomicAdd(wood_commands[first].instance_count, 1);
  for (uint i = 1; i < plant.leaf_mesh_count; ++i) atomicAdd(wood_commands[first + i].instance_count, 1);
  wood_list[plant.leaf_mesh_list_base + place] = slot;
  atomicAdd(counters.leaf_mesh_instances, 1);
  COPPICE_COUNT(leaf_mesh_triangles, plant.leaf_mesh_triangles)
}

// leaf_count: of quads
void draw_instance(HardwareDraws draws, Plant plant, uint plant_index, uint leaf_count) {
  if (draws.leaves == kDrawsMeshes) {
    COPPICE_COUNT(leaves, plant.leaf_count)
    COPPICE_COUNT(hardware_triangles, plant.leaf_mesh_triangles)
    draw_leaf_meshes(plant, plant_index, draws.slot);
  } else if (draws.leaves == kDrawsQuads) {
    uint leaves = draw_leaves(plant, plant_index, draws.slot, leaf_count);
    COPPICE_COUNT(leaves, leaves)
    COPPICE_COUNT(hardware_triangles, 2 * leaves)
  }
  if (draws.wood_lod == kMaxWoodLods) return;
  uint triangles = plant.wood_index_counts[draws.wood_lod] / 3;
  COPPICE_COUNT(wood_triangles, triangles)
  COPPICE_COUNT(hardware_triangles, triangles)
  draw_wood(plant, plant_index, draws.slot, draws.wood_lod);
}
