#version 460
#extension GL_GOOGLE_include_directive : require

// Leaf quads and wood triangles to pixels of `picture`: coverage at pixel centres, depth, which leaf it is.
// reads     view, instances, plants, cuts, work_items and big_items with their stages, picture; lists, clusters, leaves and card looks by
//           address
// writes    picture; big_items and the round's big stage
// dispatch  indirect, from the round's work stage, y: eyes, or its big stage, which kSource names; recorded by
//           coppice::gpu::LeafRaster::record_leaves
//
// Clusters: one invocation a leaf, which walks the pixels of the leaf's rectangle. What covers many pixels goes to a list
// of its own, of which a whole group takes one leaf at a time: a row each invocation, or eight of a wide group.

#include "bindings.glsl"
#include "raster_place.glsl"
#include "leaf_shading.glsl"
#include "write_pixel.glsl"

const uint kClusters = 0;
const uint kBig = 1;
layout(constant_id = 0) const uint kSource = kClusters;
layout(local_size_x_id = 1) in;
layout(constant_id = 4) const int kBigPixels = 400;  // a leaf whose rectangle holds more pixels is left to a whole group
layout(constant_id = 5) const int kRowLanes = 1;     // invocations of that group that share a row of pixels

// What the leaves of a cluster share.
struct Shared {
  uint eye;
  Placed placed;
  vec3 box_step;
  float px_per_m;  // on the screen, of a metre in object space
  uint slot;
  bool paged, finest;  // is_single
};

Shared share(uint eye, uint place_of_work, WorkItem work, ClusterList list, Cluster cluster, uint leaf_count) {
  uint item = work.item;
  Instance instance = instance_at(slot_of(item));
  Shared group;
  group.eye = eye;
  group.placed = place(eye, place_of_work, work, instance, list.box_min, list.box_step, cluster);
  group.box_step = list.box_step;
  group.slot = slot_of(item);
  group.paged = list_of(item) == kPageList;
  group.finest = list_of(item) < kPageList && leaf_count == plants[instance.plant].leaf_count;
  float distance_m = max(size_distance_m(world_from_object(instance, cluster.center)), view.near_m);
  group.px_per_m = instance.scale * view.focal_px / distance_m;
  return group;
}

// One of a leaf's two triangles on the screen. Barycentric weights of its second and third corner are b.x + b.y * x + b.z * y.
struct Triangle {
  vec3 second, third;
  vec3 key;  // likewise
};

// A leaf on the screen.
struct Drawn {
  Triangle first, other;  // (0, 1, 2) and (0, 2, 3)
  ivec2 low, high;        // pixels [low, high) hold it
  uint first_pixel;
  uint name;
  uvec2 mask;
  uint thinning;
};

// corners: px, px, depth key
Triangle triangle_of(vec3 a, vec3 b, vec3 c) {
  vec2 ab = b.xy - a.xy, ac = c.xy - a.xy;
  float area = ab.x * ac.y - ab.y * ac.x;
  float inverse = abs(area) > 1e-6 ? 1.0 / area : 0.0;
  Triangle triangle;
  triangle.second.yz = vec2(ac.y, -ac.x) * inverse;
  triangle.third.yz = vec2(-ab.y, ab.x) * inverse;
  // A triangle without area has a weight of -1 everywhere.
  triangle.second.x = inverse != 0.0 ? -dot(triangle.second.yz, a.xy) : -1.0;
  triangle.third.x = inverse != 0.0 ? -dot(triangle.third.yz, a.xy) : -1.0;
  triangle.key = triangle.second * (b.z - a.z) + triangle.third * (c.z - a.z);
  triangle.key.x += a.z;
  return triangle;
}

// False where nothing of the leaf is on the screen, or a corner of it lies before the near plane or behind the far one.
bool project(Shared group, uint at_in_cluster, Leaf leaf, out Drawn drawn) {
  vec3 corners[4];
  for (uint i = 0; i < 4; ++i) corners[i] = quantised(leaf.corners, i);
  vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  // Wood has no holes, and its triangles are no smaller from afar.
  CardLook card = CardLookArray(group.placed.cards).at[card_of_leaf(leaf.card)];
  float along_m = length(group.box_step * (0.5 * (corners[1] + corners[2] - corners[0] - corners[3])));
  float across_m = length(group.box_step * (0.5 * (corners[2] + corners[3] - corners[0] - corners[1])));
  bool outlined = group.placed.wood || outline_loss(group.px_per_m * min(along_m, across_m)) < 0.5;
  uint name = name_of(leaf, group.slot);
  bool single = is_single(leaf, group.paged, group.finest);
  float side = group.placed.wood ? 1.0 : shared_side(name, single, group.placed.leaves);
  float scale = side * (outlined ? 1.0 : sqrt(card.coverage));
  drawn.mask = outlined ? uvec2(card.mask[0], card.mask[1]) : uvec2(0xffffffffu);

  vec3 at[4];
  bool between = true;
  for (uint i = 0; i < 4; ++i) {
    vec4 corner = projected(group.placed, middle + (corners[i] - middle) * scale);
    float inverse_w = 1.0 / corner.z;
    at[i] = vec3(corner.xy, corner.w) * inverse_w;
    between = between && corner.z > 0.0 && is_between_planes(at[i].z);
  }
  vec2 low = min(min(at[0].xy, at[1].xy), min(at[2].xy, at[3].xy));
  vec2 high = max(max(at[0].xy, at[1].xy), max(at[2].xy, at[3].xy));
  // Pixels whose centres are inside.
  vec2 size = vec2(push.width_px, push.height_px);
  drawn.low = max(ivec2(ceil(clamp(low, vec2(0.0), size) - 0.5)), ivec2(0));  // also of what is no number
  drawn.high = min(ivec2(floor(clamp(high, vec2(0.0), size) - 0.5)) + 1, ivec2(size));
  drawn.first = triangle_of(at[0], at[1], at[2]);
  drawn.other = triangle_of(at[0], at[2], at[3]);
  drawn.first_pixel = first_pixel(group.eye);
  drawn.name = name_of_leaf(group.placed.first_name, at_in_cluster, push.place_bits);
  vec4 middle_px = projected(group.placed, middle);
  drawn.thinning = thinning_of(leaf, name, middle_px.xy / middle_px.z);
  return between && side > 0.0 && all(lessThan(drawn.low, drawn.high));
}

// Bit of the 8 x 8 mask. at: 0..1
bool is_hole(uvec2 mask, vec2 at) {
  uvec2 cell = min(uvec2(at * 8.0), uvec2(7));
  uint bit = cell.y * 8 + cell.x;
  return ((bit < 32 ? mask.x : mask.y) >> (bit & 31u) & 1u) == 0;
}

// Draws the pixel where it is covered. xy: its centre
void shade_pixel(Drawn drawn, vec2 xy, uint pixel) {
  vec3 one = vec3(1.0, xy);
  float b1 = dot(drawn.first.second, one), b2 = dot(drawn.first.third, one);
  float c2 = dot(drawn.other.second, one), c3 = dot(drawn.other.third, one);
  bool in_first = min(min(b1, b2), 1.0 - b1 - b2) >= 0.0;
  bool in_other = min(min(c2, c3), 1.0 - c2 - c3) >= 0.0;
  if (in_first && is_hole(drawn.mask, vec2(b1 + b2, b2))) in_first = false;
  if (in_other && is_hole(drawn.mask, vec2(c2, c2 + c3))) in_other = false;
  precise float key = max(in_first ? dot(drawn.first.key, one) : 0.0, in_other ? dot(drawn.other.key, one) : 0.0);
  bool shown = shows_pixel(drawn.thinning, uint(xy.x), uint(xy.y));
  if ((in_first || in_other) && shown) write_pixel(pixel, key, drawn.name);
}

// Where a triangle's edges cross a row: at start + step * y. A `left` edge bounds the pixels inside from there on, another up to there.
struct Edges {
  vec3 start, step;
  bvec3 left;
};

Edges edges_of(Triangle triangle) {
  vec3 first = vec3(1.0, 0.0, 0.0) - triangle.second - triangle.third;
  vec3 slope = vec3(triangle.second.y, triangle.third.y, first.y);
  // An edge along the row bounds nothing, or all of it: it is crossed far away.
  slope = mix(slope, vec3(1e-9), lessThan(abs(slope), vec3(1e-9)));
  Edges edges;
  edges.start = -vec3(triangle.second.x, triangle.third.x, first.x) / slope;
  edges.step = -vec3(triangle.second.z, triangle.third.z, first.z) / slope;
  edges.left = greaterThan(slope, vec3(0.0));
  return edges;
}

vec2 span_of(Edges edges, float y) {
  vec3 crossing = edges.start + edges.step * y;
  vec3 low = mix(vec3(-1e9), crossing, edges.left), high = mix(crossing, vec3(1e9), edges.left);
  return vec2(max(low.x, max(low.y, low.z)), min(high.x, min(high.y, high.z)));
}

struct Rows {
  Edges first, other;
};

// Pixels [x, y) of row `row` that may be covered; shade_pixel decides, so that rounding here loses nothing.
ivec2 row_of(Rows rows, Drawn drawn, int row) {
  vec2 one = span_of(rows.first, float(row) + 0.5), other = span_of(rows.other, float(row) + 0.5);
  bool any_one = one.x <= one.y, any_other = other.x <= other.y;
  float low = min(any_one ? one.x : 1e9, any_other ? other.x : 1e9), high = max(any_one ? one.y : -1e9, any_other ? other.y : -1e9);
  vec2 within = clamp(vec2(low - 0.51, high - 0.49), vec2(drawn.low.x), vec2(drawn.high.x));
  return ivec2(floor(within.x), ceil(within.y));
}

// Of the 8 rows and columns of a block, a bit each: x the upper four rows, y the others.
const int kBlock_px = 8;

// Four rows of a block from `y` on: the pixels whose centres a triangle holds. width: columns of the block that are on the screen
uint four_rows(Edges edges, vec2 block, float y, float width) {
  uint rows = 0;
  for (uint row = 0; row < 4; ++row) {
    vec2 span = span_of(edges, block.y + y + float(row) + 0.5) - block.x;
    uvec2 at = uvec2(clamp(ceil(span - 0.5), 0.0, width));
    rows |= ((0xffu << at.x) & ~(0xffu << at.y) & 0xffu) << (8 * row);
  }
  return rows;
}

uint next_bit(uvec2 bits) { return bits.x != 0 ? uint(findLSB(bits.x)) : 32u + uint(findLSB(bits.y)); }
uvec2 without_next_bit(uvec2 bits) { return bits.x != 0 ? uvec2(bits.x & (bits.x - 1), bits.y) : uvec2(0, bits.y & (bits.y - 1)); }
bool has_bit(uvec2 bits, uint bit) { return ((bit < 32 ? bits.x : bits.y) >> (bit & 31u) & 1u) != 0; }
uvec2 without_bit(uvec2 bits, uint bit) {
  uint one = ~(1u << (bit & 31u));
  return bit < 32 ? uvec2(bits.x & one, bits.y) : uvec2(bits.x, bits.y & one);
}
vec2 center_of(vec2 block, uint bit) { return block + vec2(bit & 7u, bit >> 3) + 0.5; }

// What one block of a leaf's rectangle shows. First where it is covered, by rows; then what the outline and gaps take away; then pixels, so that
// the dear part, the atomic, goes through nothing but pixels of the leaf.
// Loops end at the bottom here: software drivers go through a loop's body once more to find that no invocation is left in it.
void raster_block(Drawn drawn, Rows edges, ivec2 corner, bool seen) {
  vec2 block = vec2(corner);
  ivec2 size = clamp(drawn.high - corner, ivec2(0), ivec2(kBlock_px));
  uvec2 inside = uvec2(size.y >= 4 ? 0xffffffffu : (1u << 8 * min(size.y, 3)) - 1,
                       size.y >= 8 ? 0xffffffffu : (1u << 8 * clamp(size.y - 4, 0, 3)) - 1);
  if (!seen) inside = uvec2(0);
  float width = float(size.x);
  uvec2 first = inside & uvec2(four_rows(edges.first, block, 0.0, width), four_rows(edges.first, block, 4.0, width));
  uvec2 other = inside & uvec2(four_rows(edges.other, block, 0.0, width), four_rows(edges.other, block, 4.0, width));

  bool solid = (drawn.mask.x & drawn.mask.y) == 0xffffffffu && drawn.thinning == 0;
  uvec2 left = solid ? uvec2(0) : first | other;
  do {
    uint bit = next_bit(left);
    vec2 center = center_of(block, bit);
    vec3 one = vec3(1.0, center);
    float b1 = dot(drawn.first.second, one), b2 = dot(drawn.first.third, one);
    float c2 = dot(drawn.other.second, one), c3 = dot(drawn.other.third, one);
    bool some = (left.x | left.y) != 0;
    bool gap = !shows_pixel(drawn.thinning, uint(center.x), uint(center.y));
    if (some && (gap || is_hole(drawn.mask, vec2(b1 + b2, b2)))) first = without_bit(first, bit);
    if (some && (gap || is_hole(drawn.mask, vec2(c2, c2 + c3)))) other = without_bit(other, bit);
    left = without_next_bit(left);
  } while ((left.x | left.y) != 0);

  left = first | other;
  do {
    uint bit = next_bit(left);
    vec2 center = center_of(block, bit);
    vec3 one = vec3(1.0, center);
    precise float key = max(has_bit(first, bit) ? dot(drawn.first.key, one) : 0.0, has_bit(other, bit) ? dot(drawn.other.key, one) : 0.0);
    if ((left.x | left.y) != 0) write_pixel(drawn.first_pixel + uint(center.y) * push.width_px + uint(center.x), key, drawn.name);
    left = without_next_bit(left);
  } while ((left.x | left.y) != 0);
}

// big: as big_items have it
void raster_leaf(Shared group, uint at, Leaf leaf, uvec2 big, bool shown) {
  Drawn drawn;
  bool seen = project(group, at, leaf, drawn) && shown;
  ivec2 size = drawn.high - drawn.low;
  if (seen && size.x * size.y > kBigPixels) {
    // Where some found no place, the second pass draws all of them here: whose depth it is says what is seen.
    uint place = kPass != kName                              ? atomicAdd(rounds[push.round].big.count, 1)
                 : rounds[push.round].big.count > kBigCapacity ? kBigCapacity
                                                               : 0;
    if (kPass != kName && place < kBigCapacity) {
      atomicMax(rounds[push.round].big.groups[0], min(place + 1, kMaxDispatchGroups));
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

void raster_clusters() {
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

void raster_big() {
  uint count = min(rounds[push.round].big.count, kBigCapacity);
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

void main() {
  if (kSource == kClusters) raster_clusters();
  else raster_big();
}
