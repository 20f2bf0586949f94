#version 460
#extension GL_GOOGLE_include_directive : require

// Draw commands of the instances that the rasteriser leaves to the hardware, of all its rounds.
// reads     instances, plants, cuts, items from their end
// writes    draw commands, wood lists, counters
// dispatch  indirect, from round 0's draws stage, one invocation an instance; recorded by coppice::gpu::LeafRaster::record

#define COPPICE_CULL_ACCESS
#include "bindings.glsl"
#include "raster.glsl"
#include "counters.glsl"
#include "hardware_draws.glsl"

layout(local_size_x_id = 1) in;

void main() {
  uint count = rounds[0].draws.count;
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    HardwareDraws draws = unpacked(items[items.length() - 1 - i]);
    uint plant_index = instances[draws.slot].plant;
    Plant plant = plants[plant_index];
    draw_instance(draws, plant, plant_index, cut_leaf_count(draws.slot, plant));
  }
}
