#ifndef COPPICE_RASTER_SHARED_H
#define COPPICE_RASTER_SHARED_H

// The layouts that the compute rasteriser adds to coppice_shared.h; the same text compiles as GLSL and as C++.

#include "coppice_shared.h"

#ifdef __cplusplus
namespace coppice::gpu {
#endif

// Instances of a block lie in consecutive slots; a block is culled before its instances are read.
const uint kBlockSlots = kCullGroupSize;
// A frame has several culling passes, large instances first. The engine's depth, and the pixels of earlier passes, hide blocks, instances
// and clusters of the next.
const uint kCullingPasses = 4;
// Maximum of clusters in a frame, before any is culled; a small memory budget has fewer. Further instances are drawn with a cut of one
// cluster, for which there is space in any case.
const uint kWorkClusters = 1u << 19;
const uint kBigCapacity = 1u << 18;  // maximum of leaves in a pass that a whole workgroup rasterises
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

// VkDispatchIndirectCommand, and the number of elements to process.
struct RasterStage {
  uint groups[3];
  uint count;
};
COPPICE_GPU_LAYOUT(RasterStage, 16);

// A cluster to draw. Pixels name it, and it has the data for their light, so that nothing more is loaded.
struct WorkItem {
  uint item;     // slot_of, list_of
  uint work;     // work_of
  uvec2 splats;  // the cluster's; from kWorkSunShift of the high word on the share of the sun that gets past other plants, in kWorkSunSteps
};
COPPICE_GPU_LAYOUT(WorkItem, 16);
const uint kWorkSunShift = 25, kWorkSunSteps = 127;

// The place of a cluster in the frame before: rows of a matrix for a place of the world, and 1.
struct ClusterMotion {
  vec4 rows[3];
};
COPPICE_GPU_LAYOUT(ClusterMotion, 48);
const uint kMotionGroups = 256;  // groups of cluster_motion.comp, which process all clusters of a frame

struct CullingPass {
  RasterStage blocks, items, work, splats, big;
  RasterStage finest_tiles, other_tiles;  // no groups if the pass draws nothing
  // Used in pass 0 only, for all passes:
  RasterStage draws;  // instances that the hardware draws
  uint reserved;      // clusters reserved by instances so far
};
COPPICE_GPU_LAYOUT(CullingPass, 132);

// Push constants of every pass of the rasteriser. A depth key grows towards the eye as View::key_row says; its bits are those of a float
// above 0.
struct RasterPush {
  uint culling_pass;
  uint width_px;
  uint height_px;
  float splat_px;      // clusters with a grain up to this length are drawn as splats
  float split_px;      // the hardware draws clusters whose leaves are larger on average
  uint reversed;       // 1: the depth attachment holds the key; 0: it holds 1 - key
  uint lanes;          // invocations of a group in leaf_expand.comp, leaf_tiles.comp and hardware_draws.comp
  uint work_capacity;  // number of work_items
  uint place_bits;     // number of bits that name one of them
  // Elements that a group takes at a time: items in leaf_expand.comp; clusters of leaves, one after the other; clusters of splats, side by
  // side.
  uint expand_items;
  uint leaf_clusters;
  uint splat_clusters;
  uint eye;         // for raster_resolve.frag; other passes process all eyes
  uint hides_from;  // the first pass before which tiles hide something: 0 with an engine's occluder, else 1
  // For occluder.comp: from a pixel of the attachments to one of its images, and the maximum rounding of depth formats.
  int occluder_x_px;
  int occluder_y_px;
  float occluder_step;
  uvec2 motion;        // for cluster_motion.comp: address of ClusterMotion[], indexed as work_items
  uint work_clusters;  // clusters that instances may reserve
};
COPPICE_GPU_LAYOUT(RasterPush, 80);

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
