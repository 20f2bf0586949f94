#version 460
#extension GL_GOOGLE_include_directive : require

// Leaf quads and wood triangles to pixels of `picture`: coverage at pixel centres, depth, light once a leaf.
// reads     view, instances, plants, lists, work; leaves and cards by address
// writes    picture; big_items and the round's big stage
// dispatch  indirect, from the stage that kSource names; recorded by coppice::gpu::LeafRaster::record
//
// Clusters and tiny instances: one invocation a leaf, which walks the pixels of the leaf's rectangle. What covers many pixels goes to a list
// of its own, of which a whole group takes one leaf at a time, a row each invocation.

#include "raster_extensions.glsl"
#include "bindings.glsl"
#include "shading.glsl"
#include "leaf_shading.glsl"
#include "raster.glsl"
#include "radiance.glsl"
#include "write_pixel.glsl"

const uint kClusters = 0;
const uint kTiny = 1;
const uint kBig = 2;
layout(constant_id = 0) const uint kSource = kClusters;
layout(local_size_x_id = 1) in;

// A leaf whose rectangle holds more pixels is left to a whole group.
const int kBigPixels = 400;

// An instance's list, ready to be projected.
struct Placed {
  uint item;
  Instance instance;
  RasterList list;
  uvec2 cards;
  Crown crown;
  vec3 sun_object;
  vec3 origin, x, y, z;  // (px * w, px * w, w) of the object's origin and of a metre along its axes
};

Placed place(uint item) {
  Placed placed;
  placed.item = item;
  placed.instance = instances[slot_of(item)];
  placed.list = lists[placed.instance.plant * kRasterLists + list_of(item)];
  placed.cards = raster_plants[placed.instance.plant].cards;
  placed.crown = crown_of(plants[placed.instance.plant]);
  placed.sun_object = rotate(vec4(-placed.instance.rotation.xyz, placed.instance.rotation.w), view.sun_direction);
  placed.origin = screen_point(placed.instance.position);
  placed.x = screen_direction(rotate(placed.instance.rotation, vec3(placed.instance.scale, 0.0, 0.0)));
  placed.y = screen_direction(rotate(placed.instance.rotation, vec3(0.0, placed.instance.scale, 0.0)));
  placed.z = screen_direction(rotate(placed.instance.rotation, vec3(0.0, 0.0, placed.instance.scale)));
  return placed;
}

bool is_wood(Placed placed) { return list_of(placed.item) >= kRasterLevels; }

// One of a leaf's two triangles on the screen. Barycentric weights of its second and third corner are b.x + b.y * x + b.z * y.
struct Triangle {
  vec3 second, third;
  vec3 key;  // likewise
};

// A leaf on the screen.
struct Drawn {
  Triangle first, other;  // (0, 1, 2) and (0, 2, 3)
  ivec2 low, high;        // pixels [low, high) hold it
  uint radiance;
  uvec2 mask;
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

vec3 wood_radiance(Placed placed, RasterLeaf leaf, vec3 middle, vec3 albedo) {
  vec3 normal = rotate(placed.instance.rotation, unfold(unpackSnorm4x8(leaf.look >> 16).xy));
  float sun = sun_through_crown(placed.crown, middle, placed.sun_object) * max(0.0, dot(normal, view.sun_direction));
  return albedo * (view.sun_color * sun + ambient_light(normal) * sky_through_crown(placed.crown, middle));
}

vec3 leaf_radiance(Placed placed, RasterLeaf leaf, vec3 corners[4], vec3 middle, RasterCard card) {
  Plant plant = plants[placed.instance.plant];
  vec3 albedo = card.albedo * placed.instance.tint * variation(placed.crown, plant, uvec3(quantised(leaf.corners, 0)));
  vec3 face = cross(corners[2] - corners[0], corners[3] - corners[1]);
  return albedo * leaf_light(placed.crown, placed.instance, card.crown_normals, middle, middle, face);
}

// False where nothing of the leaf is on the screen, or a part of it lies too near.
bool project(Placed placed, RasterLeaf leaf, out Drawn drawn) {
  vec3 corners[4];
  for (uint i = 0; i < 4; ++i) corners[i] = placed.list.box_min + placed.list.box_step * quantised(leaf.corners, i);
  vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  RasterCard card = RasterCardArray(placed.cards).at[leaf.look & 0xffffu];
  bool outlined = is_wood(placed) || outline_loss(corners, placed.instance) < 0.5;
  float scale = outlined ? 1.0 : sqrt(card.coverage);
  drawn.mask = outlined ? uvec2(card.mask[0], card.mask[1]) : uvec2(0xffffffffu);

  vec3 at[4];
  float nearest = 1e30;
  for (uint i = 0; i < 4; ++i) {
    vec3 object = middle + (corners[i] - middle) * scale;
    vec3 projected = placed.origin + object.x * placed.x + object.y * placed.y + object.z * placed.z;
    float inverse_w = 1.0 / projected.z;
    at[i] = vec3(projected.xy * inverse_w, depth_key(inverse_w));
    nearest = min(nearest, projected.z);
  }
  if (!(nearest > view.near_m)) return false;
  vec2 low = min(min(at[0].xy, at[1].xy), min(at[2].xy, at[3].xy));
  vec2 high = max(max(at[0].xy, at[1].xy), max(at[2].xy, at[3].xy));
  // Pixels whose centres are inside.
  vec2 size = vec2(push.width_px, push.height_px);
  drawn.low = ivec2(ceil(clamp(low, vec2(0.0), size) - 0.5));
  drawn.high = ivec2(floor(clamp(high, vec2(0.0), size) - 0.5)) + 1;
  if (any(greaterThanEqual(drawn.low, drawn.high))) return false;
  drawn.first = triangle_of(at[0], at[1], at[2]);
  drawn.other = triangle_of(at[0], at[2], at[3]);
  return true;
}

uint radiance_of(Placed placed, RasterLeaf leaf) {
  vec3 corners[4];
  for (uint i = 0; i < 4; ++i) corners[i] = placed.list.box_min + placed.list.box_step * quantised(leaf.corners, i);
  vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  vec3 world = world_from_object(placed.instance, middle);
  RasterCard card = RasterCardArray(placed.cards).at[leaf.look & 0xffffu];
  vec3 color = is_wood(placed) ? wood_radiance(placed, leaf, middle, card.albedo) : leaf_radiance(placed, leaf, corners, middle, card);
  return pack_radiance(mix(view.fog_color, color, transmittance(world)));
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
  if (in_first || in_other) write_pixel(pixel, key, drawn.radiance);
}

// Pixels of a row where the weights of a triangle are not negative; x >= y: none.
vec2 span_of(Triangle triangle, float y, float low, float high) {
  vec3 weight[3] = {triangle.second, triangle.third, vec3(1.0, 0.0, 0.0) - triangle.second - triangle.third};
  for (int i = 0; i < 3; ++i) {
    float at_zero = weight[i].x + weight[i].z * y, slope = weight[i].y;
    float root = -at_zero / slope;
    if (slope > 0.0) low = max(low, root);
    else if (slope < 0.0) high = min(high, root);
    else if (at_zero < 0.0) high = low - 2.0;
  }
  return vec2(low, high);
}

// Pixels [x, y) of row `row` that may be covered; shade_pixel decides, so that rounding here loses nothing.
ivec2 row_of(Drawn drawn, int row) {
  vec2 one = span_of(drawn.first, float(row) + 0.5, float(drawn.low.x), float(drawn.high.x));
  vec2 other = span_of(drawn.other, float(row) + 0.5, float(drawn.low.x), float(drawn.high.x));
  bool any_one = one.x <= one.y, any_other = other.x <= other.y;
  float low = min(any_one ? one.x : 1e9, any_other ? other.x : 1e9), high = max(any_one ? one.y : -1.0, any_other ? other.y : -1.0);
  return ivec2(max(int(floor(low - 0.51)), drawn.low.x), min(int(ceil(high - 0.49)), drawn.high.x));
}

// Loops end at the bottom here: software drivers go through a loop's body once more to find that no invocation is left in it.
void raster_leaf(Placed placed, RasterLeaf leaf, uint index) {
  Drawn drawn;
  bool seen = project(placed, leaf, drawn);
  ivec2 size = drawn.high - drawn.low;
  if (seen && size.x * size.y > kBigPixels) {
    seen = false;
    if (kPass != kRadiance) {
      uint place = atomicAdd(rounds[push.round].big.count, 1);
      atomicMax(rounds[push.round].big.groups[0], min(place + 1, kMaxDispatchGroups));
      if (place < kBigCapacity) big_items[place] = uvec2(placed.item, index);
    }
  }
  drawn.radiance = radiance_of(placed, leaf);
  ivec2 at = drawn.low;
  bool more = seen;
  do {
    if (more) shade_pixel(drawn, vec2(at) + 0.5, uint(at.y) * push.width_px + uint(at.x));
    ++at.x;
    if (at.x >= drawn.high.x) at = ivec2(drawn.low.x, at.y + 1);
    more = seen && at.y < drawn.high.y;
  } while (more);
}

void raster_clusters() {
  uint count = min(rounds[push.round].work.count, kWorkCapacity);
  for (uint i = gl_WorkGroupID.x * kWorkPerGroup; i < count; i += gl_NumWorkGroups.x * kWorkPerGroup)
    for (uint j = i; j < min(i + kWorkPerGroup, count); ++j) {
      uvec2 work = work_items[j];
      Placed placed = place(work.x);
      RasterCluster cluster = RasterClusterArray(placed.list.clusters).at[work.y];
      uint leaf = gl_LocalInvocationIndex;
      do {
        uint index = cluster.first_leaf + leaf;
        if (leaf < cluster.leaf_count) raster_leaf(placed, RasterLeafArray(placed.list.leaves).at[index], index);
        leaf += gl_WorkGroupSize.x;
      } while (leaf < cluster.leaf_count);
    }
}

void raster_tiny() {
  uint count = rounds[push.round].tiny.count;
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
    Placed placed = place(tiny_items[i]);
    for (uint leaf = 0; leaf < placed.list.leaf_count; ++leaf) raster_leaf(placed, RasterLeafArray(placed.list.leaves).at[leaf], leaf);
  }
}

void raster_big() {
  uint count = min(rounds[push.round].big.count, kBigCapacity);
  for (uint i = gl_WorkGroupID.x; i < count; i += gl_NumWorkGroups.x) {
    Placed placed = place(big_items[i].x);
    RasterLeaf leaf = RasterLeafArray(placed.list.leaves).at[big_items[i].y];
    Drawn drawn;
    if (!project(placed, leaf, drawn)) continue;
    drawn.radiance = radiance_of(placed, leaf);
    for (int y = drawn.low.y + int(gl_LocalInvocationIndex); y < drawn.high.y; y += int(gl_WorkGroupSize.x)) {
      ivec2 row = row_of(drawn, y);
      for (int x = row.x; x < row.y; ++x) shade_pixel(drawn, vec2(x, y) + 0.5, uint(y) * push.width_px + uint(x));
    }
  }
}

void main() {
  if (kSource == kClusters) raster_clusters();
  else if (kSource == kTiny) raster_tiny();
  else raster_big();
}
