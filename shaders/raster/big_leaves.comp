#version 460
#extension GL_GOOGLE_include_directive : require

// Rasterises the leaves that leaf_raster.comp leaves to whole groups: one group a leaf, each invocation one row of its pixels, or eight
// invocations a row.
// reads     view, instances, plants, cuts, work_items; big_items with their stage, picture; lists, clusters, leaves and card looks by
// address
// writes    picture
// dispatch  indirect, from the pass's big stage; recorded by coppice::gpu::LeafRaster::record_leaves

#include "bindings.glsl"
#include "leaf_quad.glsl"

layout(local_size_x_id = 1) in;
layout(constant_id = 5) const int kRowLanes = 1;  // invocations that share a row of pixels

// Draws the pixel if the leaf covers it. xy: its centre
void shade_pixel(Drawn drawn, vec2 xy, uint pixel) {
  vec3 one = vec3(1.0, xy);
  float b1 = dot(drawn.first.second, one), b2 = dot(drawn.first.third, one);
  float c2 = dot(drawn.other.second, one), c3 = dot(drawn.other.third, one);
  bool in_first = min(min(b1, b2), 1.0 - b1 - b2) >= 0.0;
  bool in_other = min(min(c2, c3), 1.0 - c2 - c3) >= 0.0;
  if (in_first && is_hole(drawn.mask, vec2(b1 + b2, b2))) in_first = false;
  if (in_other && is_hole(drawn.mask, vec2(c2, c2 + c3))) in_other = false;
  precise float key = max(in_first ? dot(drawn.first.key, one) : 0.0, in_other ? dot(drawn.other.key, one) : 0.0);
  bool shown = shows_pixel(drawn.dither, uint(xy.x), uint(xy.y));
  if ((in_first || in_other) && shown) write_pixel(pixel, key, drawn.name);
}

// Pixels [x, y) of row `row` that may be covered; shade_pixel decides, so rounding here loses nothing.
ivec2 row_of(Rows rows, Drawn drawn, int row) {
  vec2 one = span_of(rows.first, float(row) + 0.5), other = span_of(rows.other, float(row) + 0.5);
  bool any_one = one.x <= one.y, any_other = other.x <= other.y;
  float low = min(any_one ? one.x : 1e9, any_other ? other.x : 1e9), high = max(any_one ? one.y : -1e9, any_other ? other.y : -1e9);
  vec2 within = clamp(vec2(low - 0.51, high - 0.49), vec2(drawn.low.x), vec2(drawn.high.x));
  return ivec2(floor(within.x), ceil(within.y));
}

void main() {
  uint count = min(culling_passes[push.culling_pass].big.count, kBigCapacity);
  for (uint i = group_index(); i < count; i += gl_NumWorkGroups.x) {
    uvec2 big = big_items[i];
    WorkItem work = work_at(big.x);
    Plant plant = plants[plant_at(slot_of(work.item))];
    ClusterList list = list_at(plant, list_of(work.item));
    Cluster cluster = cluster_at(list, cluster_of_work(work.work));
    uint at = leaf_of_big(big.y);
    Shared group = share(eye_of_big(big.y), big.x, work, list, cluster, item_leaf_count(work.item, plant, list));
    Drawn drawn;
    if (!project(group, at, LeafArray(cluster.leaves).at[at], drawn)) continue;
    Rows rows = Rows(edges_of(drawn.first), edges_of(drawn.other));
    int lane = int(gl_LocalInvocationIndex);
    for (int y = drawn.low.y + lane / kRowLanes; y < drawn.high.y; y += int(gl_WorkGroupSize.x) / kRowLanes) {
      ivec2 row = row_of(rows, drawn, y);
      for (int x = row.x + lane % kRowLanes; x < row.y; x += kRowLanes)
        shade_pixel(drawn, vec2(x, y) + 0.5, drawn.first_pixel + uint(y) * push.width_px + uint(x));
    }
  }
}
