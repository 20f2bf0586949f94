#ifndef COPPICE_SHARED_H
#define COPPICE_SHARED_H

// The only definition of layouts that both the CPU and the shaders use: the same text compiles as GLSL and as C++. Scalar block layout,
// little-endian, no manual padding. Addresses are buffer device addresses split in two: (low, high).

#ifdef __cplusplus
#include "vectors.h"

#define COPPICE_GPU_LAYOUT(type, bytes) static_assert(sizeof(type) == (bytes) && alignof(type) == 4)

namespace coppice::gpu {
#else
#define COPPICE_GPU_LAYOUT(type, bytes)
#endif

// A page holds kPageSplits splits, which bear kPageNodes nodes: node n > 0 is in page (n - 1) / kPageNodes.
const uint kPageSplits = 512;
const uint kPageNodes = 1024;
// Number of leaves that are culled together, and number of consecutive clusters, which is that of a page.
const uint kClusterLeaves = 128;
const uint kBlockClusters = kPageNodes / kClusterLeaves;
// Number of bits that name a cluster of a list.
const uint kClusterBits = 20;
const uint kMaxListClusters = 1u << kClusterBits;
// Number of bits that name a plant.
const uint kPlantBits = 17;
const uint kNoPlant = (1u << kPlantBits) - 1u;
const uint kNoTexture = 0xffffffffu;
// coppice_debug_view.
const uint kDebugLod = 1;
const uint kDebugPath = 2;
const uint kDebugOverdraw = 3;
const uint kDebugOcclusion = 4;
const uint kDebugError = 5;
const uint kDebugResidency = 6;
const uint kMaxShadowMaps = 4;
// coppice_content, and the bits of kContents in surface.glsl for each attachment.
const uint kContentLit = 1;
const uint kContentAlbedo = 2;
const uint kContentNormal = 3;
const uint kContentLight = 4;
const uint kContentUser = 5;
const uint kContentVelocity = 6;
const uint kContentBits = 4;
const uint kMaxWoodLods = 8;
const uint kMaxLeafMeshes = 16;
// Number of draw commands of a plant in wood_commands: its wood LoDs, then its chunks of leaf meshes.
const uint kMeshCommands = kMaxWoodLods + kMaxLeafMeshes;
const uint kCullGroupSize = 32;
// Side of the grid of light in a crown, and maximum values of its words (coppice_light.h): optical depth, and slope over depth.
const uint kCrownCells = 8;
const float kMaxCrownDepth = 8.0f;
const float kMaxCrownSlope = 2.0f;
// Maximum of levels and sizes in an error table.
const uint kMaxErrorLevels = 32, kMaxErrorSizes = 16;
// Number of words of one plant in the buffer of packed tables: those of coppice_lod.h, of leaf meshes and wood LoDs too, then those of
// coppice_wind.h, a PlantWind and the nodes of its grid.
const uint kWindWord = kMaxErrorLevels + kMaxErrorSizes + (kMaxErrorLevels + 1 + kMaxWoodLods) * kMaxErrorSizes;
const uint kWindNodes = 15;
const uint kMaxWindNodes = 8 * 8 * 8;
const uint kTableStride = kWindWord + kWindNodes + kMaxWindNodes;

// Cluster lists of a plant: one per ready cut, the pages, one per wood LoD, one per chunk of leaf meshes. Ready cut i is one cluster with
// the leaves of rung i of the ladder (coppice_lod.h). An instance that needs more than kReadyLeaves is drawn from the pages.
const uint kReadyLeaves = 64;
const uint kReadyCuts = 37;
const uint kPageList = kReadyCuts;
const uint kWoodLists = kPageList + 1;
const uint kMeshLists = kWoodLists + kMaxWoodLods;
const uint kClusterLists = kMeshLists + kMaxLeafMeshes;
// Draws of parts of a mesh by the hardware: maximum for an instance, and for instances of a plant.
const uint kInstanceParts = 32;
const uint kPartCommands = 8 * kInstanceParts;
// Set in gl_InstanceIndex of such a draw, beside the instance's slot.
const uint kPartBit = 1u << 31;
// Draws of a plant that are counted: of single clusters, of other clusters, of parts of each wood LoD, of parts of leaf meshes; and whether
// each of its mesh commands draws anything, 0 or 1.
const uint kSingleCount = 0, kClusterCount = 1;
const uint kWoodPartCounts = 2;
const uint kMeshPartCount = kWoodPartCounts + kMaxWoodLods;
const uint kMeshDrawn = kMeshPartCount + 1;
const uint kDrawCounts = kMeshDrawn + kMeshCommands;
// The low bits of a word name an instance, the rest one of its plant's lists.
const uint kSlotBits = 24;
const uint kMaxSlots = 1u << kSlotBits;

// A leaf quad, a node of the tree; or a triangle of wood or of a leaf mesh (corner 3 repeats corner 2). Corner i is (x, y, z), three
// unsigned 16-bit numbers; the twelve of them are packed two to a word, low half first.
struct Leaf {
  uint corners[6];
  // low half: index of the plant's cards or CardLooks; from kTransparencyShift on, 4 bits: transparency in sixteenths. 12 are free
  uint card;
  uint life;  // from kBirthShift on the split of its page that bears it; below the split that replaces it, or kNoDeath
};
COPPICE_GPU_LAYOUT(Leaf, 32);
const uint kTransparencyShift = 16;
const uint kMaxTransparency = 15;
const uint kBirthShift = 23;
const uint kNoDeath = (1u << kBirthShift) - 1u;
// Finer cuts are not drawn, because lives end here.
const uint kMaxDrawnLeaves = kNoDeath;

// The light of a leaf, and the leaf itself while it has few pixels: up to kMaxGrains discs side by side.
const uint kMaxGrains = 4;
struct Splat {
  uint xy;      // its middle in the list's box, two unsigned 16-bit numbers: box_min + splat_step * q
  uint z_size;  // the third number; and the side of the square of a disc's area times opacity, 65535 stands for Cluster::splat_size_m
  // from its middle to its end, three snorm8 of Cluster::axis_steps steps; from bit 24 on, 4 bits each, in fifteenths: LeafNormals::along,
  // roughness
  uint axis;
  uint normals;  // LeafNormals::axis and the face's normal, octahedral, two snorm8 each
  // its albedo, packed by pack_albedo; bit 31: LeafNormals::sided
  uint look;
  uint crown;  // for unpack_crown: the light at its middle
};
COPPICE_GPU_LAYOUT(Splat, 24);
const float kMaxSplatAlbedo = 2.0f;

// Leaves that die first come last: among the nodes that are born the living ones come first. Fields with four values describe the first
// quarter of kClusterLeaves leaves, two, three and all, 8 bits each: unpack_length.
struct Cluster {
  vec3 center;  // object space, m; bounds all its leaves
  float radius_m;
  uvec2 leaves;  // address of Leaf[]
  uvec2 splats;  // address of Splat[], for the same leaves
  // kCount*: leaves; log2 of discs a leaf; whether it is a surface, whose gaps between discs would show; births; whether leaves are
  // transparent
  uint counts;
  uint last_death;    // the largest of its leaves' deaths; in a mesh: its first triangle in the mesh
  uint grains_m;      // four: the longest part of a leaf that one disc replaces
  uint leaf_sizes_m;  // four: side of the square of the mean leaf's area
  float splat_size_m;
  float axis_steps;
};
COPPICE_GPU_LAYOUT(Cluster, 56);
// First bit of each field in Cluster::counts. Births: the first and the last split of its page that bears one of its leaves.
const uint kCountGrains = 8, kCountSurface = 10, kCountFirstBirth = 11, kCountLastBirth = 20, kCountTransparent = 29;
// Lengths of 8 bits: b stands for 2^((b - kLengthZero) / kLengthSteps) m, 0 for none.
const uint kLengthZero = 160;
const float kLengthSteps = 8.0f;

// The clusters of a cut, of the pages, or of all triangles of one wood LoD or chunk of leaf meshes. corner = box_min + box_step * q, object
// space, m.
struct ClusterList {
  vec3 box_min;
  uint leaf_count;
  vec3 box_step;
  uint cluster_count;  // clusters of leaves; in a mesh those whose triangles may be drawn as leaves
  uint range_count;    // in a mesh: all clusters, those of leaves first; their triangles follow each other
  vec3 splat_step;
  float leaf_size_m;  // side of the square of the mean leaf's area
  uvec2 blocks;       // address of uvec2[]: each is the address of kBlockClusters clusters, the last one of the rest
  float grain_m;      // the longest grain of its clusters
  float holed_m;      // for wood: the longest of those with holes
  float facet_m;      // for wood: side of its largest triangle's area, or the mean length over which one light for a triangle is wrong
};
COPPICE_GPU_LAYOUT(ClusterList, 72);

// The appearance of a leaf at a distance: its card's mean colour, and the card's outline in 8 x 8 cells, row by row from corner 0 (x
// towards corner 1, y towards corner 3).
struct CardLook {
  vec3 albedo;     // linear
  float coverage;  // share that is no hole
  uint mask[2];
  float roughness;  // its material's
};
COPPICE_GPU_LAYOUT(CardLook, 28);

// A place in the world is a place in a cell, from its middle, m, and three signed 16-bit numbers of the cell.
const float kCellSide_m = 1024.0f;
const int kMaxCell = 32767;

// world = position + rotation * (scale * object). One per instance slot. coppice_instance.h and coppice_light.h unpack.
struct Instance {
  vec3 position;  // in its cell
  float scale;
  // unit quaternion; w below 0: the plant is also mirrored in its foot. w is never 0, because q and -q are the same rotation
  vec4 rotation;
  uint cell_xy;
  uint cell_z_bias;   // low half: the third number of the cell; high half: as a half, added to log2 of its error threshold
  uint tint_xy;       // two halves
  uint tint_z_share;  // likewise: the third, and the share of its leaves that is drawn
  uint plant_seed;    // the plant, kNoPlant in an empty slot, and in the upper 32 - kPlantBits bits the seed
  uint layer_mask;
  uint user_data;
  // 0: it has not moved since the frame before; kCame: it did not exist then; with kGrows: pack_growth of an instance that grows up; else
  // 1 + the index of its former place in moved_texels
  uint before;
};
COPPICE_GPU_LAYOUT(Instance, 64);
const uint kCame = 0xffffffffu, kGrows = 0x80000000u;
// Flags of an instance that a draw's vertices pass to its pixels.
const uint kHasCome = 1u, kIsMirrored = 2u;

struct Card {
  uint material;
  vec2 uv[4];
};
COPPICE_GPU_LAYOUT(Card, 36);

struct Material {
  vec4 base_color;  // linear
  float alpha_cutoff;
  uint texture;         // index in the plant, or kNoTexture
  float sided_normals;  // LeafNormals::sided of its leaf meshes
  uint normal_map;      // index in the plant, or kNoTexture
  float roughness;
};
COPPICE_GPU_LAYOUT(Material, 36);

struct WoodVertex {
  vec3 position;  // object space, m
  uint normal;    // octahedral, two snorm16
  vec2 uv;
  uint material;
};
COPPICE_GPU_LAYOUT(WoodVertex, 28);

// A vertex of a leaf mesh.
struct LeafMeshVertex {
  vec3 position;  // object space, m
  uint normal;    // octahedral, two snorm16
  vec2 uv;
  uint stalk_xy;          // corner 0 of the leaf's quad, as in a node: x, y
  uint stalk_z_material;  // z, low half; the material, high half
};
COPPICE_GPU_LAYOUT(LeafMeshVertex, 32);

// What an engine changes about the surfaces of a plant.
struct MaterialOverride {
  vec3 leaf_tint;
  float leaf_roughness;  // below 0, as the two below: it changes nothing
  vec3 wood_tint;
  float wood_roughness;
  float translucency;
  vec4 parameters;
};
COPPICE_GPU_LAYOUT(MaterialOverride, 52);

struct Plant {
  vec3 sphere_center;  // object space, m; leaves and wood
  float sphere_radius;
  vec3 box_min;  // leaf vertex = box_min + box_step * q, object space, m
  uint leaf_count;
  vec3 box_step;
  uint resident_leaf_count;  // leaves of the finest cut in the resident pages; 0: its leaves cannot be drawn yet
  uint quantised_max;        // largest coordinate: box_step * quantised_max is the leaf box
  uint error_level_count;
  uint error_size_count;
  uvec2 lists;  // address of ClusterList[kClusterLists]; those of cuts and pages exist with the first page, the others as stated below
  uvec2 cards;
  uvec2 materials;
  uvec2 card_looks;            // address of CardLook[card count + material count]; the latter are for meshes
  uvec2 crown_light;           // address of uint[kCrownCells^3]: x fastest, then y
  uint instance_count;         // entries of its lists below
  uint leaf_command_base;      // [base, base + instance_count): draw commands of one cluster; then those of several clusters
  uint leaf_command_capacity;  // number of the latter
  uint part_base;              // in leaf_commands: kPartCommands for each wood LoD, then for each chunk of leaf meshes
  uint part_capacity;          // for each: kPartCommands, or 0
  uint wood_list_base;         // LoD i's instances are [base + i * instance_count, ...)
  uint wood_lod_count;
  uint wood_resident_mask;  // bit i: LoD i can be drawn. 0 until the coarsest has been uploaded
  uint wood_list_mask;      // bit i: list kWoodLists + i exists
  uint wood_index_counts[kMaxWoodLods];
  uint leaf_mesh_count;      // chunks of leaf meshes; 0 unless all of them can be drawn
  uint leaf_mesh_triangles;  // sum over all chunks
  uint leaf_mesh_list_base;  // in the wood list: instances that are drawn with leaf meshes
  uint mesh_list_count;      // number of lists from kMeshLists on; 0 unless all leaf meshes have theirs
  uint mesh_cluster_count;   // sum over all of them
  MaterialOverride material_override;
};
COPPICE_GPU_LAYOUT(Plant, 240);

// The wind of a frame. A gust is a sum of waves that travel with it; the wind repeats after kWindPeriod_s.
const uint kWindWaves = 3;
const float kWindPeriod_s = 256.0f;
// Maximum motion of a plant, and of a leaf's tip by flutter within that, relative to its sphere's radius.
const float kMaxWindReach = 0.8f, kFlutterReach = 0.01f;
// Places in coppice_wind.map. One map is the frame's, the other that of the frame before. Row-major: velocity that is added to the wind, x
// and z, m/s
const uint kMaxMapPlaces = 256u * 256u, kWindMaps = 2u;
struct WindNow {
  vec3 direction;  // unit, horizontal, downwind
  float load;      // 0: still air; 1: a gale
  float gustiness;
  float time_s;            // 0..kWindPeriod_s
  vec4 waves[kWindWaves];  // sine of (x * x + y * z + z), times w; for places from the view's eye, m
  float speed_mps;
  float max_load;   // for any plant: load, and more if the map may add to it
  float max_reach;  // maximum motion of any plant, relative to its sphere's radius
  uvec2 map;        // its first place in wind_maps, and 1; on the CPU its address. 0: there is no map
  uvec2 map_size;   // places along x and z
  vec2 map_first;   // x and z of the first one from the view's eye, m
  vec2 map_places_per_m;
};
COPPICE_GPU_LAYOUT(WindNow, 116);

// One of a view's eyes. Planes' normals point inside: dot(xyz, p) + w >= 0.
const uint kMaxEyes = 2;
struct Eye {
  mat4 clip_from_world;
  mat4 clip_from_world_before;  // the frame before's, for places in this frame's world space
  mat4 world_from_key;          // for (x, y, depth key, 1), x and y of clip space times w
  vec4 planes[5];
  vec4 key_row;  // dot(key_row, place) / w is a place's depth key: 1 at the near plane, 0 at the far one
  vec3 place;
  uvec2 first_px;  // the picture's first pixel in the attachments
};
COPPICE_GPU_LAYOUT(Eye, 308);

// The view of a frame. In shaders world space begins at the view's eye, or at the middle of two, so that floats are precise near it; only
// this struct has the eye in full. focal_px and near_m determine sizes.
struct View {
  Eye eyes[kMaxEyes];
  ivec3 eye_cell;
  vec3 eye_in_cell;
  uint layer_mask;  // instances that share no bit with it are not drawn
  float error_px;
  float focal_px;            // half the height of the picture in px, times clip_from_view[1][1]'s magnitude
  float near_m;              // smaller distances count as this
  uint lod_full;             // 1: every resident leaf
  uint lod_discrete;         // 1: cuts of discrete levels
  uint instance_slot_count;  // slots [0, this) may hold instances
  uint frame;                // number of the frame, for instances that grow up
  float fog_density;
  vec3 sun_direction;
  vec3 sun_color;
  vec3 sky_color;
  vec3 ground_color;
  vec3 fog_color;
  uint debug_view;            // coppice_debug_view
  uvec2 debug_colors;         // address of DebugColorArray: by instance slot, rgb, 8 bits each
  uvec2 instances, moved;     // addresses of the data that is read as texels if the device binds enough of them (kReadsTexels): Instance[];
  uvec2 tables, wind_maps;    // words of packed tables, vec2[]
  uint is_shadow;             // 1: its picture is a shadow map
  uint shadow_map_count;      // number of shadow_maps
  float depth_sign;           // 1: nearer places have larger depth; -1: smaller
  uint is_mirrored;           // 1: the picture's y points up, so counter-clockwise for the viewer is clockwise in it
  float is_perspective;       // 1; 0: it is parallel. Then distances count as 0, near_m is 1, and a metre has focal_px px
  vec3 toward_viewer;         // in a parallel view: unit; in a perspective 0
  uint temporal_frame;        // coppice_camera's
  vec2 half_size_px;          // half the sides of the picture
  uint has_overrides;         // 0: no plant has a MaterialOverride, so none is read
  WindNow wind, wind_before;  // wind_before: of the frame before
  mat4 map_clips[kMaxShadowMaps];  // clip_from_world of each shadow map
};
COPPICE_GPU_LAYOUT(View, 1316);

// Sums over a frame; leaf and triangle counts are 64-bit, low word first.
struct Counters {
  uint visible_instances;
  uint occluded_instances;  // in view, but hidden
  uint leaves[2];
  uint wood_triangles[2];
  uint leaf_mesh_instances;
  uint leaf_mesh_triangles[2];
  uint hardware_triangles[2];  // triangles of leaves, leaf meshes and wood
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

// Push constants of a draw. A plant's leaves, and each of its wood LoDs, are drawn once for every texture that they use: vertices whose
// material has another one collapse. Almost every plant has one leaf texture and one bark.
struct DrawPush {
  uint plant;
  uint texture;    // or kNoTexture
  uvec2 vertices;  // address of WoodVertex[], or LeafMeshVertex[] for leaf meshes; not used for leaves
  uint wood_list_first;
  uint normal_map;  // or kNoTexture; for wood and leaf meshes
  uint eye;
  uint unused;  // pads to 16 bytes
};
COPPICE_GPU_LAYOUT(DrawPush, 32);

// What cut_triangles.comp is asked for.
struct TrianglePush {
  uvec2 positions;    // address of vec3[], written
  uvec2 lists;        // leaves: address of their ClusterList
  uvec2 indices;      // mesh: address of uint[]
  uvec2 vertices;     // mesh: address of its first vertex
  uint count;         // number of leaves of the cut, or of the mesh's indices
  uint paged;         // leaves: 1 if the list is that of the pages, else all of it is shown
  uint vertex_words;  // mesh: words of a vertex; 0 for leaves
  uint unused;        // pads to 16 bytes
};
COPPICE_GPU_LAYOUT(TrianglePush, 48);

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
