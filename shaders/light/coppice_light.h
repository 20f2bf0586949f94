// Places of plants, light in crowns, colours of leaves, and their packing into words. This text compiles as GLSL and as C++ (namespace
// coppice::gpu), so the records of clusters and the shaders that draw vertices cannot differ by more than rounding.
//
// In a shader after bindings.glsl.

#ifndef COPPICE_LIGHT_H
#define COPPICE_LIGHT_H

#include "coppice_lod.h"
#include "coppice_shared.h"

// Reads word i of a plant's crown light, whose address is `words`.
#ifdef __cplusplus
#define COPPICE_CROWN_WORD(words, i) (words)[i]

namespace coppice::gpu {
using lod::coppice_hash;
using CrownWords = const uint*;
#else
#define COPPICE_CROWN_WORD(words, i) WordArray(words).at[i]
#define CrownWords uvec2
#endif

COPPICE_FN vec3 rotate(vec4 quaternion, vec3 v) {
  vec3 axis = vec3(quaternion.x, quaternion.y, quaternion.z);
  vec3 t = 2.0f * cross(axis, v);
  return v + quaternion.w * t + cross(axis, t);
}

/// Turns a direction of an instance's object space into the world; with the conjugate of its rotation, back. rotation: Instance's
COPPICE_FN vec3 oriented(vec4 rotation, vec3 v) {
  return (rotation.w < 0.0f ? -1.0f : 1.0f) * rotate(rotation, v);
}

/// z: in its low half
COPPICE_FN ivec3 unpack_cell(uint xy, uint z) {
  return ivec3(int(xy << 16u) >> 16, int(xy) >> 16, int(z << 16u) >> 16);
}
COPPICE_FN vec3 tint_of(Instance instance) {
  vec2 xy = unpackHalf2x16(instance.tint_xy);
  return vec3(xy.x, xy.y, unpackHalf2x16(instance.tint_z_share).x);
}
COPPICE_FN float leaf_share_of(Instance instance) {
  return unpackHalf2x16(instance.tint_z_share).y;
}
COPPICE_FN float lod_bias_of(Instance instance) {
  return unpackHalf2x16(instance.cell_z_bias).y;
}

#ifndef __cplusplus
// A place in a cell, relative to the view's eye.
vec3 from_eye(ivec3 cell, vec3 place) {
  return vec3(cell - view.eye_cell) * kCellSide_m + (place - view.eye_in_cell);
}

vec3 world_from_object(Instance instance, vec3 p) {
  return from_eye(unpack_cell(instance.cell_xy, instance.cell_z_bias), instance.position) + oriented(instance.rotation, instance.scale * p);
}
#endif

/// True if a single leaf is among the given share of its instance's leaves. Leaves vanish one by one as the share falls. name: the leaf's
COPPICE_FN bool is_among(uint name, float share) {
  return float(coppice_hash(name) >> 8u) * (1.0f / 16777216.0f) < share;
}

/// Maps a unit vector to the octahedron, whose lower half is folded outwards into the corners of the square. Any length is allowed; 0 gives
/// 0.
COPPICE_FN vec2 octahedral(vec3 n) {
  float sum = abs(n.x) + abs(n.y) + abs(n.z);
  if (!(sum > 0.0f)) return vec2(0.0f, 0.0f);
  vec2 e = vec2(n.x / sum, n.y / sum);
  if (n.z >= 0.0f) return e;
  return vec2((1.0f - abs(e.y)) * (e.x >= 0.0f ? 1.0f : -1.0f), (1.0f - abs(e.x)) * (e.y >= 0.0f ? 1.0f : -1.0f));
}

/// The inverse of octahedral(). Returns a unit vector
COPPICE_FN vec3 unfold(vec2 e) {
  vec3 n = vec3(e.x, e.y, 1.0f - abs(e.x) - abs(e.y));
  float fold = max(-n.z, 0.0f);
  n.x -= n.x >= 0.0f ? fold : -fold;
  n.y -= n.y >= 0.0f ? fold : -fold;
  return n * inversesqrt(dot(n, n));
}

/// Packs a length, m, into 8 bits: see kLengthZero. Lengths beyond the range become its ends.
COPPICE_FN uint pack_length(float length_m) {
  if (!(length_m > 0.0f)) return 0u;
  return uint(clamp(round(kLengthSteps * log2(length_m)) + float(kLengthZero), 1.0f, 255.0f));
}
/// Unpacks one of the four lengths in a word.
COPPICE_FN float unpack_length(uint word, uint quarter) {
  uint step = word >> (8u * quarter) & 255u;
  return step == 0u ? 0.0f : exp2((float(step) - float(kLengthZero)) / kLengthSteps);
}

/// Packs Splat::look without its upper byte, or a colour of wood. The inverse is kMaxSplatAlbedo times the square.
COPPICE_FN uint pack_albedo(vec3 albedo) {
  return packUnorm4x8(vec4(sqrt(clamp(albedo * (1.0f / kMaxSplatAlbedo), vec3(0.0f), vec3(1.0f))), 0.0f));
}

/// The crown is the ellipsoid in the box of the leaf vertices. Object space, m.
struct Crown {
  vec3 center;
  vec3 radii;
};

COPPICE_FN Crown crown_of(vec3 box_min, vec3 box_step, uint quantised_max) {
  vec3 half_box = 0.5f * float(quantised_max) * box_step;
  Crown crown;
  crown.center = box_min + half_box;
  crown.radii = max(half_box, vec3(1e-3f));
  return crown;
}

/// Light at a place in a crown, measured by clusters/crown_light.h. Optical depth towards unit direction d is depth + dot(slope, d), at
/// least 0.
struct CrownSample {
  float depth;  // on average
  vec3 slope;
  float sky;  // share of the sky's light that arrives, 0..1
};

COPPICE_FN uint pack_crown(CrownSample crown) {
  float root = round(255.0f * sqrt(min(max(0.0f, crown.depth / kMaxCrownDepth), 1.0f)));  // in this order a NaN becomes 0, here and below
  float depth = kMaxCrownDepth * root * root / (255.0f * 255.0f);
  vec3 slope = depth > 0.0f ? crown.slope / vec3(kMaxCrownSlope * depth) : vec3(0.0f);
  vec3 steps = round(31.0f * clamp(slope, vec3(-1.0f), vec3(1.0f)));
  uint slopes = (uint(int(steps.x)) & 63u) << 8u | (uint(int(steps.y)) & 63u) << 14u | (uint(int(steps.z)) & 63u) << 20u;
  return uint(root) | slopes | uint(round(63.0f * min(max(0.0f, crown.sky), 1.0f))) << 26u;
}

COPPICE_FN CrownSample unpack_crown(uint word) {
  float root = float(word & 255u) * (1.0f / 255.0f);
  CrownSample crown;
  crown.depth = kMaxCrownDepth * root * root;
  vec3 steps = vec3(float(int(word << 18u) >> 26), float(int(word << 12u) >> 26), float(int(word << 6u) >> 26));
  crown.slope = kMaxCrownSlope / 31.0f * crown.depth * steps;
  crown.sky = float(word >> 26u) * (1.0f / 63.0f);
  return crown;
}

/// Interpolates linearly between cells; a place outside the box has the light of the box's nearest place. words: uint[kCrownCells^3],
/// place: object space, m
COPPICE_FN CrownSample crown_light_at(CrownWords words, Crown crown, vec3 place) {
  vec3 at = ((place - crown.center) / crown.radii * 0.5f + vec3(0.5f)) * float(kCrownCells) - vec3(0.5f);
  at = clamp(at, vec3(0.0f), vec3(float(kCrownCells - 1u)));
  vec3 low = min(floor(at), vec3(float(kCrownCells - 2u)));
  vec3 share = at - low;
  uint first = (uint(low.z) * kCrownCells + uint(low.y)) * kCrownCells + uint(low.x);
  CrownSample sum;
  sum.depth = sum.sky = 0.0f;
  sum.slope = vec3(0.0f);
  for (uint i = 0u; i < 8u; ++i) {
    bool far_x = (i & 1u) != 0u, far_y = (i & 2u) != 0u, far_z = (i & 4u) != 0u;
    float weight = (far_x ? share.x : 1.0f - share.x) * (far_y ? share.y : 1.0f - share.y) * (far_z ? share.z : 1.0f - share.z);
    uint cell = first + (far_x ? 1u : 0u) + (far_y ? kCrownCells : 0u) + (far_z ? kCrownCells * kCrownCells : 0u);
    CrownSample corner = unpack_crown(COPPICE_CROWN_WORD(words, cell));
    sum.depth += weight * corner.depth;
    sum.slope += weight * corner.slope;
    sum.sky += weight * corner.sky;
  }
  return sum;
}

/// Varies leaves between light and dark, warm and cool. It depends on the leaf's stalk, so that it survives a change of cut. stalk_m: its
/// place, object space; stalk: the same, quantised
COPPICE_FN vec3 variation(Crown crown, vec3 stalk_m, uvec3 stalk) {
  vec3 cell = floor((stalk_m - crown.center) / crown.radii * 4.0f);
  uint tuft = coppice_hash(uint(int(cell.x) + 16) + uint(int(cell.y) + 16) * 64u + uint(int(cell.z) + 16) * 4096u);
  uint leaf = coppice_hash((stalk.x + stalk.y * 16384u) ^ (stalk.z * 747796405u));
  float a = float(tuft >> 16u) / 65535.0f - 0.5f;
  float b = float(leaf >> 16u) / 65535.0f - 0.5f;
  float c = float(leaf & 0xffffu) / 65535.0f - 0.5f;
  return (1.0f + 0.16f * a + 0.30f * b) * vec3(1.0f + 0.16f * c, 1.0f, 1.0f - 0.14f * c);
}

/// The normals of a leaf, or of those that it stands for: see coppice_surface.glsl.
struct LeafNormals {
  vec3 axis;    // unit
  float along;  // 0..1
  float sided;  // 0 or 1
};

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
