#version 460
#extension GL_GOOGLE_include_directive : require

// Finds the blocks of instances of a culling pass: those of its size on screen, in view, not hidden.
// reads     view, blocks, in all passes but the first tiles
// writes    visible_blocks and the pass's blocks stage; counters
// dispatch  an invocation a block, kCullGroupSize a group; recorded by coppice::gpu::LeafRaster::record

#include "bindings.glsl"
#include "coppice_light.h"
#include "raster.glsl"
#include "counters.glsl"
#include "occlusion.glsl"

layout(local_size_x = kCullGroupSize) in;

// The culling pass for a size on screen, as a share of the picture's height.
uint culling_pass_of(float share) {
  if (share > 0.55) return 0;
  if (share > 0.22) return 1;
  return share > 0.08 ? 2 : 3;
}

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (index * kBlockSlots >= view.instance_slot_count) return;
  InstanceBlock block = blocks[index];
  if (block.radius_m < 0.0) return;
  vec3 center = from_eye(unpack_cell(block.cell_xy, block.cell_z), block.center);
  float radius_m = block.radius_m + view.wind.max_reach * block.max_instance_radius_m;
  float nearest_m = size_distance_m(center) - block.radius_m;
  float size_px = coppice_projected_size_px(nearest_m, block.max_instance_radius_m, view.near_m, view.focal_px);
  if (culling_pass_of(size_px / float(push.height_px)) != push.culling_pass) return;
  if (!sphere_in_view(center, radius_m)) return;
  if (occluded(center, radius_m)) {
    atomicAdd(counters.occluded_instances, block.instance_count);
    return;
  }
  uint place = atomicAdd(culling_passes[push.culling_pass].blocks.count, 1);
  atomicMax(culling_passes[push.culling_pass].blocks.groups[0], min(place + 1, kMaxDispatchGroups));
  visible_blocks[place] = index;
}
