// What the hardware draws of an instance, as draw commands and places in the wood lists. After bindings.glsl with COPPICE_CULL_ACCESS and
// counters.glsl.

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

void draw_leaves(Plant plant, uint plant_index, uint slot, uint leaf_count) {
  uint node_count = 2 * leaf_count - 1;
  uint draw_count = (node_count + kNodesPerDraw - 1) / kNodesPerDraw;
  uint first = atomicAdd(leaf_counts[plant_index], draw_count);
  // The count must not pass what the device draws at once; what took a place below the capacity keeps it.
  if (first + draw_count > plant.leaf_command_capacity) atomicMin(leaf_counts[plant_index], plant.leaf_command_capacity);
  for (uint i = 0; i < draw_count && first + i < plant.leaf_command_capacity; ++i) {
    DrawCommand command;
    command.index_count = 6 * min(node_count - i * kNodesPerDraw, kNodesPerDraw);
    command.instance_count = 1;
    command.first_index = 0;
    command.vertex_offset = int(4 * i * kNodesPerDraw);
    command.first_instance = slot;
    leaf_commands[plant.leaf_command_base + first + i] = command;
  }
}

void draw_wood(Plant plant, uint plant_index, uint slot, uint lod) {
  uint place = atomicAdd(wood_commands[plant_index * kMeshCommands + lod].instance_count, 1);
  wood_list[plant.wood_list_base + lod * plant.wood_list_stride + place] = slot;
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
    COPPICE_COUNT(leaves, leaf_count)
    COPPICE_COUNT(hardware_triangles, 2 * leaf_count)
    draw_leaves(plant, plant_index, draws.slot, leaf_count);
  }
  if (draws.wood_lod == kMaxWoodLods) return;
  uint triangles = plant.wood_index_counts[draws.wood_lod] / 3;
  COPPICE_COUNT(wood_triangles, triangles)
  COPPICE_COUNT(hardware_triangles, triangles)
  draw_wood(plant, plant_index, draws.slot, draws.wood_lod);
}
