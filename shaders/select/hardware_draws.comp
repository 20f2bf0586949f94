#version 460
#extension GL_GOOGLE_include_directive : require

// Writes draw commands of the wood and leaf meshes that the rasteriser leaves to the hardware, in all its culling passes.
// reads     view, instances, plants, pass 0's draws stage, items from their end; lists and clusters by address
// writes    leaf_commands, draw_counts, wood_commands, wood_list, counters
// dispatch  indirect, from pass 0's draws stage, one invocation an instance; recorded by coppice::gpu::LeafRaster::record

#define COPPICE_CULL_ACCESS
#include "bindings.glsl"
#include "raster.glsl"
#include "counters.glsl"
#include "mesh_draws.glsl"

layout(local_size_x_id = 1) in;

void main() {
  uint count = min(culling_passes[0].draws.count, uint(items.length()));
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    MeshDraws draws = unpacked(items[items.length() - 1 - i]);
    uint plant_index = plant_at(draws.slot);
    uint triangles = draw_meshes(draws, plants[plant_index], plant_index);
    COPPICE_COUNT(hardware_triangles, triangles)
  }
}
