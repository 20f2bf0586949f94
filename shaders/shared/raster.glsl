// Descriptor set 1 of the compute rasteriser, written by gpu/view/leaf_raster.cpp, and functions that its passes share. After
// bindings.glsl.
// The picture and the tiles are those of the first eye, then of the second. A pixel of the picture is two words: the leaf's name (see
// names.glsl), then its depth key. Without a leaf the name is 0, and the key is that of the engine's depth there, or 0. Read as one 64-bit
// number, the larger one is the nearer leaf.

#extension GL_KHR_shader_subgroup_ballot : require

#include "raster_shared.h"
#include "clusters.glsl"
#include "names.glsl"
#define COPPICE_ACCESS
#include "raster_reads.glsl"

layout(set = 1, binding = 1, scalar) readonly buffer BlockBuffer { InstanceBlock blocks[]; };
layout(set = 1, binding = 2, scalar) buffer CullingPassBuffer { CullingPass culling_passes[]; };
layout(set = 1, binding = 3, scalar) buffer VisibleBlockBuffer { uint visible_blocks[]; };
// For slot_of and list_of; from the end on MeshDraws of all passes.
layout(set = 1, binding = 4, scalar) buffer ItemBuffer { uint items[]; };
layout(set = 1, binding = 6, scalar) buffer BigBuffer { uvec2 big_items[]; };         // a place in work_items, big_leaf
layout(set = 1, binding = 7, scalar) buffer TileBuffer { uint tiles[]; };             // the smallest key of each tile, level by level

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CardLookArray { CardLook at[]; };

// Packs a leaf of a cluster, and the eye that sees it large.
uint big_leaf(uint eye, uint leaf) { return eye << 31 | leaf; }
uint eye_of_big(uint big) { return big >> 31; }
uint leaf_of_big(uint big) { return big & ~(1u << 31); }

// Places in work_items. Clusters of splats are stored from the first place on, those of leaves from the last one down, for all passes: a
// pixel names a place until the view is culled again.
const uint kLeafWork = 0, kSplatWork = 1;
uint work_place(uint list, uint index) { return list == kSplatWork ? index : push.work_capacity - 1 - index; }
// Number of clusters of a list in earlier passes.
uint earlier_work(uint list) {
  uint count = 0;
  for (uint i = 0; i < push.culling_pass; ++i) count += list == kSplatWork ? culling_passes[i].splats.count : culling_passes[i].work.count;
  return count;
}
// Number of clusters in a pass's list, limited to the last place.
uint work_count(uint list, uint earlier) {
  uint count = list == kSplatWork ? culling_passes[push.culling_pass].splats.count : culling_passes[push.culling_pass].work.count;
  return min(count, push.work_capacity - min(earlier, push.work_capacity));
}

// x: columns, y: rows, z: place of the level's first tile.
uvec3 tile_level(uint level) {
  uint first = 0;
  uvec2 size = uvec2(0);
  for (uint i = 0; i <= level; ++i) {
    first += size.x * size.y;
    uint shift = kTileShift + 2 * i;
    size = (uvec2(push.width_px, push.height_px) + (1u << shift) - 1) >> shift;
  }
  return uvec3(size, first);
}

// A number for each group. Software drivers give each core one run of consecutive groups. This numbering gives every core some of every
// part of a list, whose beginning is often more work.
uint group_index() {
  uint half_count = (gl_NumWorkGroups.x + 1) / 2;
  return gl_WorkGroupID.x < half_count ? 2 * gl_WorkGroupID.x : 2 * (gl_WorkGroupID.x - half_count) + 1;
}

// Index of the second eye's first tile.
uint tile_count() {
  uvec3 last = tile_level(kTileLevels - 1);
  return last.z + last.x * last.y;
}

// Index of the first pixel of an eye's picture.
uint first_pixel(uint eye) { return eye * push.width_px * push.height_px; }

// (x * w, y * w, w) in px of a point, or of a direction, whose fourth number is 0; and its depth key times w.
vec4 on_screen(uint eye, vec4 world) {
  vec4 clip = view.eyes[eye].clip_from_world * world;
  return vec4(0.5 * vec2(push.width_px, push.height_px) * (clip.xy + clip.w), clip.w, dot(view.eyes[eye].key_row, world));
}

// True if a place with this depth key lies between the near plane and the far one. w > 0
bool is_between_planes(float key) { return key > 0.0 && key <= 1.0; }
