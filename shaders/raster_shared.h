#ifndef COPPICE_RASTER_SHARED_H
#define COPPICE_RASTER_SHARED_H

// The layout of what the compute rasteriser adds to coppice_shared.h; the same text compiles as GLSL and as C++.

#include "coppice_shared.h"

#ifdef __cplusplus
namespace coppice::gpu {
#endif

// Instances of a block lie in consecutive slots; a block is culled before its instances are looked at.
const uint kBlockSlots = kCullGroupSize;
// A frame is rasterised in rounds, large instances first. What a round has covered hides blocks, instances and clusters of the next.
const uint kRasterRounds = 4;
// Leaf lists of a plant, one per rung of the ladder of cuts (leaf_lists.h), then one list per wood LoD, then one per chunk of leaf meshes.
const uint kRasterLevels = 80;
const uint kRasterMeshes = kRasterLevels + kMaxWoodLods;
const uint kRasterLists = kRasterMeshes + kMaxLeafMeshes;
// Leaves (or wood triangles) of a list that are culled together.
const uint kClusterLeaves = 64;
// A work item names its instance with the low bits and its list with the rest.
const uint kSlotBits = 24;
const uint kRasterMaxInstances = 1u << kSlotBits;
// Clusters in a round, before any is culled. Instances beyond are drawn with the rung of one cluster, for which there is room besides.
const uint kWorkClusters = 1u << 19;
const uint kOneClusterLevel = 18;    // kClusterLeaves leaves
const uint kBigCapacity = 1u << 18;  // leaves in a round that a whole workgroup rasterises
const uint kTileShift = 3;
const uint kTileSide_px = 1u << kTileShift;
const uint kTileLevels = 3;  // tiles of 8, 32 and 128 px
const uint kMaxDispatchGroups = 16384;

// The radius is negative where the block has no instance.
struct InstanceBlock {
  vec3 center;
  float radius_m;
  float max_instance_radius_m;
  uint instance_count;
};
COPPICE_GPU_LAYOUT(InstanceBlock, 24);

// A leaf quad, or a triangle of wood or of a leaf mesh (corner 3 repeats corner 2): three unsigned 16-bit numbers a corner, packed as in
// Node.
struct RasterLeaf {
  uint corners[6];
  uint card;     // RasterCard of the plant
  uint normals;  // as in RasterSplat
  uint look;     // as in RasterSplat
  uint crown;    // unpack_crown: the light at its middle
};
COPPICE_GPU_LAYOUT(RasterLeaf, 40);

// A leaf of few pixels, or one of up to kMaxGrains equal parts along a long one: a place, an area and what its light needs.
const uint kMaxGrains = 4;
struct RasterSplat {
  uint xy;       // place in the list's box, two unsigned 16-bit numbers of which 65535 is the far side
  uint z_size;   // the third; and the side of the square of the covered area, 65535 is RasterList::splat_size_m
  uint normals;  // the one it is lit with and its face's, octahedral, two snorm8 each
  // Its albedo, packed as in packed_albedo, but of wood the place of it in RasterPlant::wood_colors; from bit 24 on the share of the sky
  // that it sees.
  uint look;
};
COPPICE_GPU_LAYOUT(RasterSplat, 16);
const float kMaxSplatAlbedo = 2.0f;

// A textured material's colours, as wood shows them: the means of its texture's parts, 32 x 32 of them, then 16 x 16, and so on to one.
// Rows of u, from v = 0 on.
const uint kWoodColorSide = 32;
const uint kWoodColors = (4u * kWoodColorSide * kWoodColorSide - 1u) / 3u;

struct RasterCluster {
  vec3 center;  // object space, m
  float radius_m;
  uint first_leaf;
  uint leaf_count;
  uint first_splat;
  uint splat_count;
  float grain_m;      // the longest part of a leaf that one splat stands for
  uint crown;         // unpack_crown: the mean light of its leaves' middles
  float bulk;         // how much of the crown one of its leaves stands for: leaf_light's
  float leaf_size_m;  // side of the square of the mean leaf's area
  uint is_surface;    // 1: of triangles without holes, between which discs would leave gaps
};
COPPICE_GPU_LAYOUT(RasterCluster, 52);

// All leaves of one cut, or all triangles of one wood LoD or chunk of leaf meshes. corner = box_min + box_step * q, object space, m.
struct RasterList {
  vec3 box_min;
  uint leaf_count;
  vec3 box_step;
  uint cluster_count;
  uvec2 leaves;       // address of RasterLeaf[leaf_count]
  uvec2 splats;       // address of RasterSplat[]
  uvec2 clusters;     // address of RasterCluster[cluster_count]
  float leaf_size_m;  // side of the square of the mean leaf's area
  float splat_size_m;
  vec3 splat_step;  // place of a splat = box_min + splat_step * q
  float grain_m;    // the longest of its clusters'
  float holed_m;    // of wood: the longest of those with holes
  float facet_m;    // of wood: side of its largest triangle's area, or how long one light for a triangle is wrong, in the mean
};
COPPICE_GPU_LAYOUT(RasterList, 88);

// What a leaf shows from afar: its card's mean colour, and the card's outline in 8 x 8 cells, row by row from corner 0 (x towards
// corner 1, y towards corner 3).
struct RasterCard {
  vec3 albedo;     // linear
  float coverage;  // share that is no hole
  uint mask[2];
  float crown_normals;  // its material's
};
COPPICE_GPU_LAYOUT(RasterCard, 28);

struct RasterPlant {
  uvec2 cards;         // address of RasterCard[card count + material count]; the latter are for meshes
  uvec2 wood_colors;   // address of albedos, packed as in RasterSplat::look; that of a triangle is known before its texture is there
  uint level_count;    // lists [0, this) are there; 0: the plant is drawn by the hardware
  uint wood_mask;      // bit i: list kRasterLevels + i is there
  uint mesh_count;     // lists kRasterMeshes on are there; 0 unless all leaf meshes have theirs
  uint mesh_clusters;  // of all of them
};
COPPICE_GPU_LAYOUT(RasterPlant, 32);

// VkDispatchIndirectCommand and how much there is to do.
struct RasterStage {
  uint groups[3];
  uint count;
};
COPPICE_GPU_LAYOUT(RasterStage, 16);

struct RasterRound {
  RasterStage blocks, items, work, splats, big;
  RasterStage finest_tiles, other_tiles;  // no groups where the round draws nothing
  RasterStage draws;                      // of round 0 alone: instances of all rounds that the hardware draws
  uint reserved;                          // clusters of the instances so far
};
COPPICE_GPU_LAYOUT(RasterRound, 132);

// Push constants of every pass of the rasteriser. A depth key grows towards the eye: key_a + key_b / w, as the bits of a float above 0.
struct RasterPush {
  uint round;
  uint width_px;
  uint height_px;
  float key_a;
  float key_b;
  float splat_px;      // clusters whose grain is no longer than this are drawn as splats
  float split_px;      // clusters whose leaves are larger on average are drawn by the hardware
  uint reversed;       // 1: the depth attachment holds the key; 0: it holds 1 - key
  uint lanes;          // invocations of a group of leaf_expand.comp, leaf_tiles.comp and hardware_draws.comp
  uint work_capacity;  // of work_items and of splat_items
  // What a group takes at a time: items of leaf_expand.comp; clusters of leaves, one after the other; clusters of splats, side by side.
  uint expand_items;
  uint leaf_clusters;
  uint splat_clusters;
};
COPPICE_GPU_LAYOUT(RasterPush, 52);

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
