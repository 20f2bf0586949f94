#ifndef COPPICE_SHARED_H
#define COPPICE_SHARED_H

// The layout of everything the CPU and the shaders both touch, and its only definition: the same text compiles as GLSL and as C++.
// Scalar block layout, little-endian, no hand-made padding. Addresses are buffer device addresses split in two: (low, high).

#ifdef __cplusplus
#include <cstdint>

#define COPPICE_GPU_LAYOUT(type, bytes) static_assert(sizeof(type) == (bytes) && alignof(type) == 4)

namespace coppice::gpu {

using uint = std::uint32_t;
struct vec2 {
  float x, y;
};
struct vec3 {
  float x, y, z;
};
struct vec4 {
  float x, y, z, w;
};
struct uvec2 {
  uint x, y;
};
struct mat4 {
  float column[16];
};
#else
#define COPPICE_GPU_LAYOUT(type, bytes)
#endif

// A page slot of the pool: the nodes of kPageSplits splits. Node 0 is in Plant, node n > 0 is node (n - 1) % kPageNodes of page
// (n - 1) / kPageNodes.
const uint kPageSplits = 512;
const uint kPageNodes = 1024;
// A leaf draw command covers this many nodes: four 16-bit indices each.
const uint kNodesPerDraw = 16384;
const uint kNoPlant = 0xffffffffu;
const uint kNeverSplit = 0xffffffffu;
const uint kNoTexture = 0xffffffffu;
// coppice_debug_view.
const uint kDebugLod = 1;
const uint kDebugPath = 2;
const uint kDebugOverdraw = 3;
const uint kDebugOcclusion = 4;
const uint kDebugError = 5;
const uint kDebugResidency = 6;
const uint kMaxCascades = 3;
const uint kMaxWoodLods = 8;
const uint kMaxLeafMeshes = 16;
// Draw commands of a plant among wood_commands: its wood LoDs, then its chunks of leaf meshes.
const uint kMeshCommands = kMaxWoodLods + kMaxLeafMeshes;
const uint kCullGroupSize = 32;
// A side of the grid of light in a crown, and what its words (gpu/crown_light.h) hold at most: optical depth, and slope over depth.
const uint kCrownCells = 8;
const float kMaxCrownDepth = 8.0f;
const float kMaxCrownSlope = 2.0f;
// How far a leaf that stands for a whole crown is open to the sky.
const float kBulkSky = 0.8f;
// Words of the buffer of packed tables (see coppice_lod.h) that belong to one plant: 32 levels, 16 sizes, leaf meshes, 8 wood LoDs.
const uint kTableStride = 32 + 16 + (32 + 1 + 8) * 16;

// A leaf quad. Corner i is (x, y, z), three unsigned 16-bit numbers; the twelve of them are packed two to a word, low half first.
struct Node {
  uint corners[6];
  uint card;   // low half; the other is the CPU's
  uint split;  // the split that replaces this node, or kNeverSplit
};
COPPICE_GPU_LAYOUT(Node, 32);

// world = position + rotation * (scale * object). One per instance slot; plant is kNoPlant in an empty slot.
struct Instance {
  vec3 position;
  float scale;
  vec4 rotation;
  vec3 tint;
  uint plant;
};
COPPICE_GPU_LAYOUT(Instance, 48);

struct Card {
  uint material;
  vec2 uv[4];
};
COPPICE_GPU_LAYOUT(Card, 36);

struct Material {
  vec4 base_color;  // linear
  float alpha_cutoff;
  uint texture;         // of the plant, or kNoTexture
  float coverage;       // share of its cards that is no hole
  float crown_normals;  // how far its leaves' normals turn to the crown's
  uint normal_map;      // texture of the plant, or kNoTexture
};
COPPICE_GPU_LAYOUT(Material, 36);

struct WoodVertex {
  vec3 position;  // object space, m
  uint normal;    // octahedral, two snorm16
  vec2 uv;
  uint material;
};
COPPICE_GPU_LAYOUT(WoodVertex, 28);

// A vertex of the leaves as they were modelled.
struct LeafMeshVertex {
  vec3 position;  // object space, m
  uint normal;    // octahedral, two snorm16
  vec2 uv;
  uint stalk_xy;          // corner 0 of the leaf's quad, as in Node: x, y
  uint stalk_z_material;  // z, low half; the material, high half
};
COPPICE_GPU_LAYOUT(LeafMeshVertex, 32);

struct Plant {
  vec3 sphere_center;  // object space, m; leaves and wood
  float sphere_radius;
  vec3 box_min;  // leaf vertex = box_min + box_step * q, object space, m
  uint leaf_count;
  vec3 box_step;
  uint resident_leaf_count;  // the finest cut the resident pages hold
  uint quantised_max;        // largest coordinate: box_step * quantised_max is the leaf box
  Node root;
  uint error_level_count;
  uint error_size_count;
  uvec2 pages;  // address of uvec2[page count]: the address of each resident page's slot
  uvec2 cards;
  uvec2 materials;
  uvec2 crown_light;       // address of uint[kCrownCells^3]: x fastest, then y
  uint leaf_command_base;  // this plant's draw commands are [base, base + capacity)
  uint leaf_command_capacity;
  uint wood_list_base;  // LoD i's instances are [base + i * wood_list_stride, ...)
  uint wood_list_stride;
  uint wood_lod_count;
  uint wood_resident_mask;  // bit i: LoD i can be drawn. 0 until the coarsest has been uploaded
  uint wood_index_counts[kMaxWoodLods];
  uint leaf_mesh_count;      // chunks of leaf meshes; 0 unless all of them can be drawn
  uint leaf_mesh_triangles;  // of all of them
  uint leaf_mesh_list_base;  // in the wood list: instances that are drawn with leaf meshes
};
COPPICE_GPU_LAYOUT(Plant, 192);

// What a frame is seen with. Planes are world space, normals point inside: dot(xyz, p) + w >= 0.
struct View {
  mat4 clip_from_world;
  vec4 planes[5];
  vec3 camera_position;
  float error_px;
  float focal_px;            // half the height of the picture in px, times clip_from_view[1][1]'s magnitude
  float near_m;              // nearer instances count as this far away
  uint lod_full;             // 1: every resident leaf
  uint lod_discrete;         // 1: cuts are the discrete levels'
  uint instance_slot_count;  // slots [0, this) may hold instances
  float fog_density;
  vec3 sun_direction;
  vec3 sun_color;
  vec3 sky_color;
  vec3 ground_color;
  vec3 fog_color;
  uint debug_view;              // coppice_debug_view
  uvec2 debug_colors;           // address of DebugColorArray: by instance slot, rgb, 8 bits each
  uint is_shadow;               // 1: its picture is a shadow map
  uint cascade_count;           // of shadow_maps
  float depth_sign;             // 1: nearer is larger; -1: smaller
  uint is_mirrored;             // 1: the picture's y points up, so that what the viewer sees run counter-clockwise is clockwise there
  mat4 cascades[kMaxCascades];  // clip_from_world of each
};
COPPICE_GPU_LAYOUT(View, 464);

// Sums over a frame; leaf and triangle counts are 64-bit, low word first.
struct Counters {
  uint visible_instances;
  uint occluded_instances;  // in view, but hidden
  uint leaves[2];
  uint wood_triangles[2];
  uint leaf_mesh_instances;
  uint leaf_mesh_triangles[2];
  uint hardware_triangles[2];  // of leaves, leaf meshes and wood
};
COPPICE_GPU_LAYOUT(Counters, 44);

// VkDrawIndexedIndirectCommand.
struct DrawCommand {
  uint index_count;
  uint instance_count;
  uint first_index;
  int vertex_offset;
  uint first_instance;
};
COPPICE_GPU_LAYOUT(DrawCommand, 20);

// Push constants of a draw. A plant's leaves, and each of its wood LoDs, are drawn once for every texture they use: vertices whose
// material has another one collapse. Almost every plant has one leaf texture and one bark.
struct DrawPush {
  uint plant;
  uint texture;    // or kNoTexture
  uvec2 vertices;  // address of WoodVertex[], of leaf meshes LeafMeshVertex[]; of leaves from lists the plant's RasterList[]
  uint wood_list_first;
  uint normal_map;  // or kNoTexture; of wood and leaf meshes
};
COPPICE_GPU_LAYOUT(DrawPush, 24);

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
