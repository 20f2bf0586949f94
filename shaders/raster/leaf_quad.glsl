// A leaf quad or triangle of wood on the screen: its corners, its coverage of pixels, the crossings of its edges with a row. After
// bindings.glsl.

#include "raster_place.glsl"
#include "leaf_shading.glsl"
#include "write_pixel.glsl"

// Shared by the leaves of a cluster.
struct Shared {
  uint eye;
  Placed placed;
  uint seed;
  bool paged, finest;  // for is_single
};

Shared share(uint eye, uint place_of_work, WorkItem work, ClusterList list, Cluster cluster, uint leaf_count) {
  uint item = work.item;
  Instance instance = instance_at(slot_of(item));
  Shared group;
  group.eye = eye;
  group.placed = place(eye, place_of_work, work, instance, list.box_min, list.box_step, cluster);
  group.seed = seed_of(instance);
  group.paged = list_of(item) == kPageList;
  group.finest = list_of(item) < kPageList && leaf_count == plants[plant_of(instance)].leaf_count;
  return group;
}

// One of a leaf's two triangles on the screen. Barycentric weights of its second and third corner are b.x + b.y * x + b.z * y.
struct Triangle {
  vec3 second, third;
  vec3 key;  // weights for the depth key, in the same form
};

// A leaf on the screen.
struct Drawn {
  Triangle first, other;  // (0, 1, 2) and (0, 2, 3)
  ivec2 low, high;        // pixels [low, high) contain it
  uint first_pixel;
  uint name;
  uvec2 mask;
  uint dither;
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

// False if nothing of the leaf is on the screen, or a corner lies before the near plane or behind the far one.
bool project(Shared group, uint at_in_cluster, Leaf leaf, out Drawn drawn) {
  vec3 corners[4];
  for (uint i = 0; i < 4; ++i) corners[i] = quantised(leaf.corners, i);
  vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  CardLook card = CardLookArray(group.placed.cards).at[card_of_leaf(leaf.card)];
  uint name = name_of(leaf, group.seed);
  bool single = is_single(leaf, group.paged, group.finest);
  float side = group.placed.wood ? 1.0 : shared_side(name, single, group.placed.leaves);
  drawn.mask = uvec2(card.mask[0], card.mask[1]);

  vec3 at[4];
  bool between = true;
  for (uint i = 0; i < 4; ++i) {
    vec4 corner = projected(group.placed, middle + (corners[i] - middle) * side);
    float inverse_w = 1.0 / corner.z;
    at[i] = vec3(corner.xy, corner.w) * inverse_w;
    between = between && corner.z > 0.0 && is_between_planes(at[i].z);
  }
  vec2 low = min(min(at[0].xy, at[1].xy), min(at[2].xy, at[3].xy));
  vec2 high = max(max(at[0].xy, at[1].xy), max(at[2].xy, at[3].xy));
  // Pixels whose centres are inside.
  vec2 size = vec2(push.width_px, push.height_px);
  drawn.low = max(ivec2(ceil(clamp(low, vec2(0.0), size) - 0.5)), ivec2(0));  // NaN becomes 0 too
  drawn.high = min(ivec2(floor(clamp(high, vec2(0.0), size) - 0.5)) + 1, ivec2(size));
  drawn.first = triangle_of(at[0], at[1], at[2]);
  drawn.other = triangle_of(at[0], at[2], at[3]);
  drawn.first_pixel = first_pixel(group.eye);
  drawn.name = name_of_leaf(group.placed.first_name, at_in_cluster, push.place_bits);
  vec4 middle_px = projected(group.placed, middle);
  drawn.dither = dither_of(leaf, name, middle_px.xy / middle_px.z);
  return between && side > 0.0 && all(lessThan(drawn.low, drawn.high));
}

// Bits of an 8 x 8 block or mask, row by row: x has the upper four rows. Without branches, which some compilers translate into slow code.
uint next_bit(uvec2 bits) { return mix(32u + uint(findLSB(bits.y)), uint(findLSB(bits.x)), bits.x != 0); }
uvec2 bit_mask(uint bit) { return mix(uvec2(0u), uvec2(1u << (bit & 31u)), equal(uvec2(bit >> 5u), uvec2(0u, 1u))); }
bool has_bit(uvec2 bits, uint bit) { return (bits & bit_mask(bit)) != uvec2(0u); }

// at: 0..1
bool is_hole(uvec2 mask, vec2 at) {
  uvec2 cell = min(uvec2(at * 8.0), uvec2(7));
  return !has_bit(mask, cell.y * 8 + cell.x);
}

// Crossings of a triangle's edges with a row: at start + step * y. A `left` edge bounds the pixels inside from there on, another up to
// there.
struct Edges {
  vec3 start, step;
  bvec3 left;
};

Edges edges_of(Triangle triangle) {
  vec3 first = vec3(1.0, 0.0, 0.0) - triangle.second - triangle.third;
  vec3 slope = vec3(triangle.second.y, triangle.third.y, first.y);
  // An edge along the row bounds nothing, or all of it: its crossing is far away.
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
