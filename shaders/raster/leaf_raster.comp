#version 460
#extension GL_GOOGLE_include_directive : require

// Rasterises leaf quads and wood triangles into `picture`: coverage at pixel centres, depth, the leaf's name.
// reads     view, instances, plants, cuts, work_items with their stage, picture; lists, clusters, leaves and card looks by address
// writes    picture; big_items and the pass's big stage
// dispatch  indirect, from the pass's work stage, y: eyes; recorded by coppice::gpu::LeafRaster::record_leaves
//
// One invocation walks the pixels of one leaf's rectangle. Leaves of many pixels go to a list for big_leaves.comp.

#include "bindings.glsl"
#include "leaf_quad.glsl"

layout(local_size_x_id = 1) in;
layout(constant_id = 4) const int kBigPixels = 400;  // a leaf whose rectangle holds more pixels is left to a whole group

// A bit for each of the 8 rows and columns of a block: x the upper four rows, y the others.
const int kBlock_px = 8;

// Mask of four rows of a block from `y` on: the pixels whose centres are in a triangle. width: columns of the block that are on the screen
uint four_rows(Edges edges, vec2 block, float y, float width) {
  uint rows = 0;
  for (uint row = 0; row < 4; ++row) {
    vec2 span = span_of(edges, block.y + y + float(row) + 0.5) - block.x;
    uvec2 at = uvec2(clamp(ceil(span - 0.5), 0.0, width));
    rows |= ((0xffu << at.x) & ~(0xffu << at.y) & 0xffu) << (8 * row);
  }
  return rows;
}

vec2 center_of(vec2 block, uint bit) { return block + vec2(bit & 7u, bit >> 3) + 0.5; }

// Draws one block of a leaf's rectangle. It finds the covered pixels by rows, removes those that outline and transparency leave out, and
// then visits the remaining pixels, so that the expensive atomic runs for pixels of the leaf only.
// Loops end at the bottom here: software drivers run a loop's body once more to find that no invocation is left in it.
void raster_block(Drawn drawn, Rows edges, ivec2 corner, bool seen) {
  vec2 block = vec2(corner);
  ivec2 size = clamp(drawn.high - corner, ivec2(0), ivec2(kBlock_px));
  uvec2 inside = uvec2(size.y >= 4 ? 0xffffffffu : (1u << 8 * min(size.y, 3)) - 1,
                       size.y >= 8 ? 0xffffffffu : (1u << 8 * clamp(size.y - 4, 0, 3)) - 1);
  if (!seen) inside = uvec2(0);
  float width = float(size.x);
  uvec2 first = inside & uvec2(four_rows(edges.first, block, 0.0, width), four_rows(edges.first, block, 4.0, width));
  uvec2 other = inside & uvec2(four_rows(edges.other, block, 0.0, width), four_rows(edges.other, block, 4.0, width));

  bool solid = (drawn.mask.x & drawn.mask.y) == 0xffffffffu && drawn.dither == 0;
  uvec2 left = solid ? uvec2(0) : first | other;
  do {
    uint bit = next_bit(left);
    vec2 center = center_of(block, bit);
    vec3 one = vec3(1.0, center);
    float b1 = dot(drawn.first.second, one), b2 = dot(drawn.first.third, one);
    float c2 = dot(drawn.other.second, one), c3 = dot(drawn.other.third, one);
    bool gap = !shows_pixel(drawn.dither, uint(center.x), uint(center.y));
    bool hole_first = is_hole(drawn.mask, vec2(b1 + b2, b2)), hole_other = is_hole(drawn.mask, vec2(c2, c2 + c3));
    uvec2 one_bit = left & bit_mask(bit);
    first &= ~mix(uvec2(0u), one_bit, bvec2(gap || hole_first));
    other &= ~mix(uvec2(0u), one_bit, bvec2(gap || hole_other));
    left &= ~one_bit;
  } while ((left.x | left.y) != 0);

  left = first | other;
  do {
    uint bit = next_bit(left);
    vec2 center = center_of(block, bit);
    vec3 one = vec3(1.0, center);
    precise float key =
        max(mix(0.0, dot(drawn.first.key, one), has_bit(first, bit)), mix(0.0, dot(drawn.other.key, one), has_bit(other, bit)));
    if ((left.x | left.y) != 0) write_pixel(drawn.first_pixel + uint(center.y) * push.width_px + uint(center.x), key, drawn.name);
    left &= ~bit_mask(bit);
  } while ((left.x | left.y) != 0);
}

// big: as in big_items
void raster_leaf(Shared group, uint at, Leaf leaf, uvec2 big, bool shown) {
  Drawn drawn;
  bool seen = project(group, at, leaf, drawn) && shown;
  ivec2 size = drawn.high - drawn.low;
  if (seen && size.x * size.y > kBigPixels) {
    // If some leaves found no place, the second pass draws all of them here: the depth decides which one is visible.
    uint place = kPass != kName                                               ? atomicAdd(culling_passes[push.culling_pass].big.count, 1)
                 : culling_passes[push.culling_pass].big.count > kBigCapacity ? kBigCapacity
                                                                              : 0;
    if (kPass != kName && place < kBigCapacity) {
      atomicMax(culling_passes[push.culling_pass].big.groups[0], min(place + 1, kMaxDispatchGroups));
      big_items[place] = big;
    }
    seen = place >= kBigCapacity;
  }
  Rows edges = Rows(edges_of(drawn.first), edges_of(drawn.other));
  ivec2 corner = drawn.low;
  bool more = seen;
  do {
    raster_block(drawn, edges, corner, more);
    corner.x += kBlock_px;
    if (corner.x >= drawn.high.x) corner = ivec2(drawn.low.x, corner.y + kBlock_px);
    more = seen && corner.y < drawn.high.y;
  } while (more);
}

void main() {
  uint earlier = earlier_work(kLeafWork), count = work_count(kLeafWork, earlier);
  for (uint i = group_index() * push.leaf_clusters; i < count; i += gl_NumWorkGroups.x * push.leaf_clusters)
    for (uint j = i; j < min(i + push.leaf_clusters, count); ++j) {
      uint place_of_work = work_place(kLeafWork, earlier + j);
      WorkItem work = work_at(place_of_work);
      Plant plant = plants[plant_at(slot_of(work.item))];
      ClusterList list = list_at(plant, list_of(work.item));
      uint index = cluster_of_work(work.work);
      Cluster cluster = cluster_at(list, index);
      ShownLeaves shown = shown_of_work(work.work);
      uint leaf_count = item_leaf_count(work.item, plant, list), splits = born_splits(leaf_count, index);
      Shared group = share(gl_WorkGroupID.y, place_of_work, work, list, cluster, leaf_count);
      uint at = gl_LocalInvocationIndex;
      do {
        if (at < shown.count) {
          Leaf leaf = LeafArray(cluster.leaves).at[at];
          bool born = !shown.partly_born || is_born(leaf.life, splits);
          raster_leaf(group, at, leaf, uvec2(place_of_work, big_leaf(group.eye, at)), born);
        }
        at += gl_WorkGroupSize.x;
      } while (at < shown.count);
    }
}
