// Stochastic transparency: decides which pixels of a merged leaf are drawn. This text compiles as GLSL and as C++ (namespace coppice::gpu).
//
// A merged leaf stands for several leaves with gaps between them, and its transparency is the share of the gaps, in sixteenths. Each of its
// pixels has a threshold, and is drawn if that is not below the transparency. So the mean over a few pixels, or over the frames that
// temporal antialiasing averages, has the right transparency. Thresholds form a lattice over the picture that fills [0, 1) evenly with any
// few neighbours (R2: Roberts, The Unreasonable Effectiveness of Quasirandom Sequences), and advance by an irrational step from frame to
// frame. Leaves differ in phase, in one of four lattices and in one of eight steps, so that a leaf and the leaves behind it leave out
// different pixels.
//
// In a shader after bindings.glsl.

#ifndef COPPICE_TRANSPARENCY_H
#define COPPICE_TRANSPARENCY_H

#include "coppice_lod.h"
#include "coppice_shared.h"

#ifdef __cplusplus
namespace coppice::gpu {
using lod::coppice_hash;
#endif

// These unpack Leaf::card:
/// Index of the plant's cards, or CardLooks.
COPPICE_FN uint card_of_leaf(uint card) {
  return card & ((1u << kTransparencyShift) - 1u);
}
COPPICE_FN uint transparency_of_leaf(uint card) {
  return card >> kTransparencyShift & kMaxTransparency;
}

/// Share of a leaf's pixels that are drawn.
COPPICE_FN float opacity_of(uint transparency) {
  return 1.0f - float(transparency) * (1.0f / 16.0f);
}

// A leaf's dither is a word: its transparency, kMaxTransparency at most; its lattice; and its threshold at pixel (0, 0), of which only the
// upper bits count.
const uint kLatticeBits = 0x30u;
const uint kDitherBits = kLatticeBits | kMaxTransparency;

/// The lattice's contribution to the threshold at a pixel.
COPPICE_FN uint lattice_at(uint dither, uint x, uint y) {
  bool swapped = (dither & 0x10u) != 0u, mirrored = (dither & 0x20u) != 0u;
  uint p = swapped ? y : x, q = swapped ? x : y;
  return p * 3242174889u + (mirrored ? 0u - q : q) * 2447445414u;  // 2^32 times 1 / g and 1 / g^2, where g^3 = g + 1
}

/// Made of some words of a Leaf's corners and of an instance's seed, which are the same in every cut that shows the leaf.
COPPICE_FN uint leaf_name(uint first_word, uint middle_word, uint last_word, uint seed) {
  return coppice_hash(first_word ^ middle_word * 2654435769u ^ last_word * 2246822519u ^ seed * 3266489917u);
}

/// frame: View::temporal_frame; x, y: the pixel of the leaf's middle. The fixed pattern moves with the leaf, so that it does not slide over
/// the leaf when the camera moves.
COPPICE_FN uint leaf_dither(uint transparency, uint name, uint frame, uint x, uint y) {
  uint which = name >> 6u & 3u;
  // 2^32 times the fractions of the golden ratio and of the roots of 2, 3 and 7.
  uint step = which == 0u ? 2654435769u : which == 1u ? 1779033704u : which == 2u ? 3144134278u : 2773480762u;
  step = (name & 0x100u) != 0u ? 0u - step : step;
  uint threshold = frame == 0u ? name - lattice_at(name, x, y) : name + frame * step;
  return transparency == 0u ? 0u : (threshold & ~kDitherBits) | (name & kLatticeBits) | transparency;
}

/// True for every pixel of an opaque leaf: its dither is 0.
COPPICE_FN bool shows_pixel(uint dither, uint x, uint y) {
  return (dither + lattice_at(dither, x, y)) >> 28u >= (dither & kMaxTransparency);
}

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
