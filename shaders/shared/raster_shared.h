#ifndef COPPICE_RASTER_SHARED_H
#define COPPICE_RASTER_SHARED_H

// The layout of what the compute rasteriser adds to coppice_shared.h; the same text compiles as GLSL and as C++.

#include "coppice_shared.h"

#ifdef __cplusplus
namespace coppice::gpu {
#endif

// Instances of a block lie in consecutive slots; a block is culled before its instances are looked at.
const uint kBlockSlots = kCullGroupSize;
// A frame is rasterised in rounds, large instances first. What the engine has drawn before, and what a round has covered, hides blocks,
// instances and clusters of the next.
const uint kRasterRounds = 4;
// Clusters in a frame, before any is culled. Instances beyond are drawn with the cut of one cluster, for which there is room besides.
const uint kWorkClusters = 1u << 19;
const uint kBigCapacity = 1u << 18;  // leaves in a round that a whole workgroup rasterises
const uint kTileShift = 3;
const uint kTileSide_px = 1u << kTileShift;
const uint kTileLevels = 3;  // tiles of 8, 32 and 128 px
const uint kMaxDispatchGroups = 16384;

// The radius is negative where the block has no instance.
struct InstanceBlock {
  vec3 center;  // in its cell
  float radius_m;
  float max_instance_radius_m;
  uint instance_count;
  uint cell_xy;
  uint cell_z;
};
COPPICE_GPU_LAYOUT(InstanceBlock, 32);

// VkDispatchIndirectCommand and how much there is to do.
struct RasterStage {
  uint groups[3];
  uint count;
};
COPPICE_GPU_LAYOUT(RasterStage, 16);

// A cluster to draw. A pixel names one: what its light needs of it is here, so that it loads no more.
struct WorkItem {
  uint item;     // slot_of, list_of
  uint work;     // work_of
  uvec2 splats;  // the cluster's; from kWorkSunShift of the high word on the share of the sun that gets past other plants, kWorkSunSteps
};
COPPICE_GPU_LAYOUT(WorkItem, 16);
const uint kWorkSunShift = 25, kWorkSunSteps = 127;

// Where what a cluster shows was in the frame before: rows of what takes a place of the world, and 1, there.
struct ClusterMotion {
  vec4 rows[3];
};
COPPICE_GPU_LAYOUT(ClusterMotion, 48);
const uint kMotionGroups = 256;  // of cluster_motion.comp, which go through all clusters of a frame

struct RasterRound {
  RasterStage blocks, items, work, splats, big;
  RasterStage finest_tiles, other_tiles;  // no groups where the round draws nothing
  // Of round 0 alone, for all rounds:
  RasterStage draws;  // instances that the hardware draws
  uint reserved;      // clusters of the instances so far
};
COPPICE_GPU_LAYOUT(RasterRound, 132);

// Push constants of every pass of the rasteriser. A depth key grows towards the eye, View::key_row says how; as the bits of a float above
// 0.
struct RasterPush {
  uint round;
  uint width_px;
  uint height_px;
  float splat_px;      // clusters whose grain is no longer than this are drawn as splats
  float split_px;      // clusters whose leaves are larger on average are drawn by the hardware
  uint reversed;       // 1: the depth attachment holds the key; 0: it holds 1 - key
  uint lanes;          // invocations of a group of leaf_expand.comp, leaf_tiles.comp and hardware_draws.comp
  uint work_capacity;  // of work_items
  uint place_bits;     // that name a place of them
  // What a group takes at a time: items of leaf_expand.comp; clusters of leaves, one after the other; clusters of splats, side by side.
  uint expand_items;
  uint leaf_clusters;
  uint splat_clusters;
  uint eye;         // of raster_resolve.frag; other passes go through all eyes
  uint hides_from;  // the first round before which tiles hide something: 0 with an occluder of the engine's, else 1
  // Of occluder.comp: from a pixel of the attachments to one of its images, and what depth formats round at most.
  int occluder_x_px;
  int occluder_y_px;
  float occluder_step;
  uvec2 motion;  // of cluster_motion.comp: address of ClusterMotion[], by place in work_items
  uint unused;   // to 16 bytes
};
COPPICE_GPU_LAYOUT(RasterPush, 80);

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
