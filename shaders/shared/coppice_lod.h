// The level-of-detail metric. This text compiles as GLSL and as C++ (namespace coppice::lod), so the CPU reference, the streamer and the
// compute shader cannot differ by more than rounding.
//
// Units. A plant's size is the projected diameter of its bounding sphere, in px. error_px = size_px * rmse / 255: the side of the square of
// completely wrong pixels that has the same summed squared error as the cut. A cut is good enough if error_px <= threshold_px.
//
// A shader that includes this file defines first
//     #define COPPICE_TABLE_WORD(table, i)  uint: word i of the plant's packed table, e.g. tables.words[(table).first_word + (i)]
// The packed table is, in 32-bit words: uint leaf_counts[L] | float sizes_px[S] | float error_px[L][S] | float leaf_mesh_error_px[S], 0 for
// a plant without leaf meshes | float wood_error_px[W][S].

#ifndef COPPICE_LOD_H
#define COPPICE_LOD_H

#ifdef __cplusplus

#include "vectors.h"

#define COPPICE_FN [[nodiscard]] inline
#define COPPICE_CONST inline constexpr
#define COPPICE_TABLE_WORD(table, i) (table).words[(table).first_word + (i)]

namespace coppice::lod {

#else

#define COPPICE_FN
#define COPPICE_CONST const

#endif

/// The place and the dimensions of a plant's packed table. L >= 1, S >= 1; leaf_counts[L - 1] is N.
struct CoppiceTable {
#ifdef __cplusplus
  const uint* words;
#endif
  uint first_word;
  uint level_count;     // L
  uint size_count;      // S
  uint wood_lod_count;  // W, 0 for a plant without wood
};

/// An instance's threshold differs from the global one by up to this share, so that a ring of plants does not switch in one frame.
COPPICE_CONST float kCoppiceThresholdSpread = 0.06f;
/// Wood may be wrong by this many thresholds of its instance: its triangles cost as much as leaves, and people look at pots and trunks.
COPPICE_CONST float kCoppiceWoodThresholdShare = 2.0f;
/// node_split of a node that is never split.
COPPICE_CONST uint kCoppiceNoSplit = 0xffffffffu;

/// Cap of coppice_projected_size_px: far beyond any table, and small enough for every sum and conversion that follows.
COPPICE_CONST float kCoppiceMaxSizePx = 16777216.0f;

COPPICE_FN uint coppice_table_leaf_count(CoppiceTable table, uint level) {
  return COPPICE_TABLE_WORD(table, level);
}
COPPICE_FN float coppice_table_size_px(CoppiceTable table, uint i) {
  return uintBitsToFloat(COPPICE_TABLE_WORD(table, table.level_count + i));
}
COPPICE_FN float coppice_table_error_px(CoppiceTable table, uint level, uint i) {
  return uintBitsToFloat(COPPICE_TABLE_WORD(table, table.level_count + table.size_count + level * table.size_count + i));
}
/// Indices of the rows behind those of the levels, for coppice_level_error_px: the error of all quads against the leaf meshes, and that of
/// a wood LoD.
COPPICE_FN uint coppice_leaf_mesh_row(CoppiceTable table) {
  return table.level_count;
}
COPPICE_FN uint coppice_wood_row(CoppiceTable table, uint lod) {
  return table.level_count + 1u + lod;
}

/// Projected diameter, px, of a sphere of radius_m whose centre is distance_m from the eye. It uses the distance, not the depth, because
/// turning the head must not change a level. A distance below near_m (> 0) counts as near_m, so the size is large and finite inside a
/// crown. focal_px: half the image height times clip_from_view[1][1]'s magnitude. The result is at most kCoppiceMaxSizePx, even if the
/// arithmetic overflows.
COPPICE_FN float coppice_projected_size_px(float distance_m, float radius_m, float near_m, float focal_px) {
  float size_px = 2.0f * radius_m * focal_px / max(distance_m, near_m);
  return size_px < kCoppiceMaxSizePx ? size_px : kCoppiceMaxSizePx;  // in this order a NaN counts as large
}

/// Position of a size among the table's sizes: i + t stands for a share t, in log size, of the way from sizes[i] to sizes[i + 1]. `scale`
/// multiplies the error: it is 1 inside the table; above it the error grows as the size does. Below the table the first column is used. It
/// is computed once an instance; functions that need an error or a cut take it instead of a size.
struct CoppiceColumn {
  uint i;
  float t;
  float scale;
  float size_px;
};

COPPICE_FN CoppiceColumn coppice_column(CoppiceTable table, float size_px) {
  CoppiceColumn column;
  column.i = 0u;
  column.t = 0.0f;
  column.scale = 1.0f;
  column.size_px = size_px;
  uint last = table.size_count - 1u;
  float largest_px = coppice_table_size_px(table, last);
  if (size_px >= largest_px) {
    column.i = last;
    column.scale = size_px / largest_px;
    return column;
  }
  if (size_px <= coppice_table_size_px(table, 0u)) return column;
  while (column.i + 2u < table.size_count && coppice_table_size_px(table, column.i + 1u) <= size_px) column.i = column.i + 1u;
  float low = log2(coppice_table_size_px(table, column.i));
  float high = log2(coppice_table_size_px(table, column.i + 1u));
  column.t = clamp((log2(size_px) - low) / (high - low), 0.0f, 1.0f);
  return column;
}

/// E(level's leaf count, size), px; for a row behind the levels, that row's error.
COPPICE_FN float coppice_level_error_px(CoppiceTable table, uint level, CoppiceColumn column) {
  float error = coppice_table_error_px(table, level, column.i);
  if (column.t > 0.0f) error += (coppice_table_error_px(table, level, column.i + 1u) - error) * column.t;
  return error * column.scale;
}

/// E(leaf_count, size), px, linear in log m between two levels: the inverse of coppice_leaf_count. leaf_count: 1..N
COPPICE_FN float coppice_error_px(CoppiceTable table, float leaf_count, CoppiceColumn column) {
  uint level = 0u;
  while (level + 2u < table.level_count && float(coppice_table_leaf_count(table, level + 1u)) <= leaf_count) level = level + 1u;
  float error = coppice_level_error_px(table, level, column);
  if (table.level_count < 2u) return error;
  float low = log2(float(coppice_table_leaf_count(table, level)));
  float high = log2(float(coppice_table_leaf_count(table, level + 1u)));
  float share = clamp((log2(leaf_count) - low) / max(high - low, 1e-6f), 0.0f, 1.0f);
  return error + (coppice_level_error_px(table, level + 1u, column) - error) * share;
}

/// The smallest fractional m in [1, N] with E(m, size) <= threshold_px; N if there is none.
COPPICE_FN float coppice_leaf_count(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  uint low = 0u;  // error above the threshold
  float low_error = coppice_level_error_px(table, low, column);
  if (low_error <= threshold_px) return float(coppice_table_leaf_count(table, low));
  uint high = table.level_count - 1u;  // error at or below it
  float high_error = coppice_level_error_px(table, high, column);
  if (high_error > threshold_px) return float(coppice_table_leaf_count(table, high));
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    float error = coppice_level_error_px(table, middle, column);
    if (error > threshold_px) {
      low = middle;
      low_error = error;
    } else {
      high = middle;
      high_error = error;
    }
  }
  float share = (low_error - threshold_px) / (low_error - high_error);
  float low_log = log2(float(coppice_table_leaf_count(table, low)));
  float high_log = log2(float(coppice_table_leaf_count(table, high)));
  return clamp(exp2(low_log + (high_log - low_log) * share), float(coppice_table_leaf_count(table, low)),
               float(coppice_table_leaf_count(table, high)));
}

/// Minimum number of leaves for a small plant, per threshold of its width. Its error is small because it is small, but a crown of one or
/// two leaves looks smaller than the crown. Beyond the maximum the table asks for more by itself.
COPPICE_CONST float kCoppiceLeavesPerThreshold = 2.0f;
COPPICE_CONST float kCoppiceMaxKeptLeaves = 32.0f;
/// The cut to draw for a size: coppice_leaf_count, but at least the minimum for small plants.
COPPICE_FN float coppice_drawn_leaf_count(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  float kept = min(kCoppiceLeavesPerThreshold * column.size_px, kCoppiceMaxKeptLeaves * threshold_px) / max(threshold_px, 1e-6f);
  kept = min(kept, float(coppice_table_leaf_count(table, table.level_count - 1u)));
  return max(coppice_leaf_count(table, column, threshold_px), kept);
}

/// The whole cut that draws a fractional m, whose last split is under way. The slack keeps exp2(log2(n)) from costing a leaf.
COPPICE_FN uint coppice_whole_leaf_count(float fractional) {
  float whole = ceil(fractional * 0.999999f);
  return whole > 1.0f ? uint(min(whole, 2147483648.0f)) : 1u;  // a NaN, from an error table that overflows, becomes 1
}

/// Error, px, of all quads against the leaf meshes; 0 for a plant without them. Beyond the table it grows with the size: the share of wrong
/// pixels is constant.
COPPICE_FN float coppice_leaf_mesh_error_px(CoppiceTable table, CoppiceColumn column) {
  return coppice_level_error_px(table, coppice_leaf_mesh_row(table), column);
}

/// True if the error of quads is above the threshold: the instance is drawn with its leaf meshes if they are resident.
COPPICE_FN bool coppice_needs_leaf_meshes(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  return coppice_leaf_mesh_error_px(table, column) > threshold_px;
}

/// The part of the threshold that is left for the cut of an instance whose size is close to that of leaf meshes. The table's errors are
/// against all quads; the quads' own error against the meshes adds to them as squares do. At the size where meshes take over, the cut
/// becomes all quads, so the picture then changes by no more than the threshold.
COPPICE_FN float coppice_cut_threshold_px(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  float error = coppice_leaf_mesh_error_px(table, column);
  return sqrt(max(threshold_px * threshold_px - error * error, 0.0f));
}

/// Number of rungs per doubling in the ladder of coarse cuts that all instances of a plant share: rung i holds about 2^(i / 6) leaves.
COPPICE_CONST float kCoppiceRungsPerDoubling = 6.0f;
COPPICE_FN uint coppice_ladder_leaf_count(uint rung) {
  return uint(ceil(exp2(float(rung) / kCoppiceRungsPerDoubling) - 0.001f));
}

/// The lowest rung with at least leaf_count leaves. leaf_count >= 1
COPPICE_FN uint coppice_ladder_rung(uint leaf_count) {
  return uint(max(ceil(kCoppiceRungsPerDoubling * log2(float(leaf_count)) - 0.005f), 0.0f));
}

/// Number of discrete levels of a plant: all N leaves, a quarter of them, and so on.
COPPICE_CONST uint kCoppiceDiscreteLevels = 7u;
/// The smallest discrete level with at least a fractional m's leaves. 1 <= leaf_count <= all
COPPICE_FN float coppice_discrete_leaf_count(float leaf_count, uint all) {
  float level_leaves = float(all);
  for (uint level = 1u; level < kCoppiceDiscreteLevels; level = level + 1u) {
    float coarser = ceil(0.25f * level_leaves);
    if (coarser < leaf_count) return level_leaves;
    level_leaves = coarser;
  }
  return level_leaves;
}

/// True if a node belongs to cut(leaf_count): it exists (id < 2m - 1) and none of the first m - 1 splits replaced it.
/// node_split  the split that replaces the node, kCoppiceNoSplit if none does or it is not resident
COPPICE_FN bool coppice_node_alive(uint node, uint node_split, uint leaf_count) {
  return node < 2u * leaf_count - 1u && node_split >= leaf_count - 1u;
}

/// Error, px, of a wood LoD against the finest.
COPPICE_FN float coppice_wood_error_px(CoppiceTable table, uint lod, CoppiceColumn column) {
  return coppice_level_error_px(table, coppice_wood_row(table, lod), column);
}

/// The coarsest wood LoD whose error is at most kCoppiceWoodThresholdShare thresholds; 0, the finest, if there is none. wood_lod_count must
/// be > 0.
COPPICE_FN uint coppice_wood_lod(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  uint lod = table.wood_lod_count - 1u;
  while (lod > 0u && coppice_wood_error_px(table, lod, column) > kCoppiceWoodThresholdShare * threshold_px) lod = lod - 1u;
  return lod;
}

/// The LoD to draw: the chosen one, else the nearest coarser one that is resident (the coarsest always is once uploaded), else the nearest
/// finer one. Bit i of the mask: LoD i is resident. wood_lod_count if the mask is empty.
COPPICE_FN uint coppice_resident_wood_lod(uint resident_mask, uint chosen, uint wood_lod_count) {
  for (uint lod = chosen; lod < wood_lod_count; lod = lod + 1u)
    if ((resident_mask & (1u << lod)) != 0u) return lod;
  for (uint lod = chosen; lod > 0u; lod = lod - 1u)
    if ((resident_mask & (1u << (lod - 1u))) != 0u) return lod - 1u;
  return wood_lod_count;
}

/// A well mixed 32-bit hash (PCG's output permutation over one LCG step).
COPPICE_FN uint coppice_hash(uint x) {
  uint state = x * 747796405u + 2891336453u;
  uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

/// The threshold of one instance: threshold_px * (1 +- kCoppiceThresholdSpread), fixed by the instance's seed.
COPPICE_FN float coppice_instance_threshold_px(float threshold_px, uint seed) {
  float unit = float(coppice_hash(seed) >> 8u) * (1.0f / 16777216.0f);
  return threshold_px * (1.0f + kCoppiceThresholdSpread * (2.0f * unit - 1.0f));
}

#ifdef __cplusplus
}  // namespace coppice::lod
#endif

#endif
