// The level-of-detail metric, once: this text compiles as GLSL and as C++ (namespace coppice::lod), so that the CPU reference, the
// streamer and the compute shader cannot disagree by more than rounding.
//
// Units. A plant's size is the projected diameter of its bounding sphere, in px. error_px = size_px * rmse / 255: the side of the square
// of completely wrong pixels that has the same summed squared error as the cut. A cut is good enough when error_px <= threshold_px.
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

/// Where a plant's packed table lies and how large it is. L >= 1, S >= 1; leaf_counts[L - 1] is N.
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
/// Times an instance's threshold that its wood may be wrong by: its triangles cost as much as leaves, and pots and trunks are looked at.
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
/// The rows behind those of the levels, for coppice_level_error_px: of all quads against the leaf meshes, and of a wood LoD.
COPPICE_FN uint coppice_leaf_mesh_row(CoppiceTable table) {
  return table.level_count;
}
COPPICE_FN uint coppice_wood_row(CoppiceTable table, uint lod) {
  return table.level_count + 1u + lod;
}

/// Projected diameter, px, of a sphere of radius_m whose centre is distance_m from the eye. The distance, not the depth: turning the head
/// must not change a level. Nearer than near_m (> 0) counts as near_m, so from inside a crown the size is large and finite. focal_px  half
/// the image height times clip_from_view[1][1]'s magnitude. At most kCoppiceMaxSizePx, also where the arithmetic overflows.
COPPICE_FN float coppice_projected_size_px(float distance_m, float radius_m, float near_m, float focal_px) {
  float size_px = 2.0f * radius_m * focal_px / max(distance_m, near_m);
  return size_px < kCoppiceMaxSizePx ? size_px : kCoppiceMaxSizePx;  // in this order a NaN counts as large
}

/// Position of a size among the table's: i + t stands for a share t, in log size, of the way from sizes[i] to sizes[i + 1].
/// `scale` multiplies the error: 1 inside the table; above it the error grows as the size does. Below it the first column holds.
/// Looked for once an instance: what an error or a cut is asked for takes it instead of a size.
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

/// E(level's leaf count, size), px; of a row behind the levels what that measures.
COPPICE_FN float coppice_level_error_px(CoppiceTable table, uint level, CoppiceColumn column) {
  float error = coppice_table_error_px(table, level, column.i);
  if (column.t > 0.0f) error += (coppice_table_error_px(table, level, column.i + 1u) - error) * column.t;
  return error * column.scale;
}

/// E(leaf_count, size), px, between two levels linear in log m: the inverse of coppice_leaf_count. leaf_count: 1..N
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

/// The smallest fractional m in [1, N] with E(m, size) <= threshold_px; N where there is none.
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

/// Leaves that a small plant keeps, for each threshold that it is wide: its error is small because it is, and a crown of a leaf or two is
/// seen to be smaller than the crown. Beyond the most the table asks for more by itself.
COPPICE_CONST float kCoppiceLeavesPerThreshold = 2.0f;
COPPICE_CONST float kCoppiceMostKeptLeaves = 32.0f;
/// What is drawn of a plant of a size: coppice_leaf_count, but no fewer than small plants keep.
COPPICE_FN float coppice_drawn_leaf_count(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  float kept = min(kCoppiceLeavesPerThreshold * column.size_px, kCoppiceMostKeptLeaves * threshold_px) / max(threshold_px, 1e-6f);
  kept = min(kept, float(coppice_table_leaf_count(table, table.level_count - 1u)));
  return max(coppice_leaf_count(table, column, threshold_px), kept);
}

/// The whole cut that draws fractional m: its last split is under way. The slack keeps exp2(log2(n)) from costing a leaf.
COPPICE_FN uint coppice_whole_leaf_count(float fractional) {
  float whole = ceil(fractional * 0.999999f);
  return whole > 1.0f ? uint(min(whole, 2147483648.0f)) : 1u;  // a NaN, from an error table that overflows, is 1
}

/// Error, px, of all quads against the leaf meshes; 0 where a plant has none. Beyond the table it grows with the size: the share of wrong
/// pixels stays.
COPPICE_FN float coppice_leaf_mesh_error_px(CoppiceTable table, CoppiceColumn column) {
  return coppice_level_error_px(table, coppice_leaf_mesh_row(table), column);
}

/// Whether quads would be too wrong for an instance: it is drawn with its leaf meshes, where they are resident.
COPPICE_FN bool coppice_wants_leaf_meshes(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  return coppice_leaf_mesh_error_px(table, column) > threshold_px;
}

/// What is left of the threshold for the cut of an instance that is near to being drawn with its leaf meshes. The table's errors are
/// against all quads, whose own against the meshes adds to them as squares do; towards the size where meshes take over the cut becomes all
/// quads, so that the picture then changes by no more than the threshold.
COPPICE_FN float coppice_cut_threshold_px(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  float error = coppice_leaf_mesh_error_px(table, column);
  return sqrt(max(threshold_px * threshold_px - error * error, 0.0f));
}

/// Rungs of the ladder of coarse cuts that are ready for all instances of a plant: rung i holds about 2^(i / 6) leaves.
COPPICE_CONST float kCoppiceRungsPerDoubling = 6.0f;
COPPICE_FN uint coppice_ladder_leaf_count(uint rung) {
  return uint(ceil(exp2(float(rung) / kCoppiceRungsPerDoubling) - 0.001f));
}

/// The lowest rung with at least so many leaves. leaf_count >= 1
COPPICE_FN uint coppice_ladder_rung(uint leaf_count) {
  return uint(max(ceil(kCoppiceRungsPerDoubling * log2(float(leaf_count)) - 0.005f), 0.0f));
}

/// Levels of a plant where it has few: all N leaves, a quarter of them, and so on.
COPPICE_CONST uint kCoppiceDiscreteLevels = 7u;
/// The fewest leaves among the discrete levels that are no fewer than a fractional m's. 1 <= leaf_count <= all
COPPICE_FN float coppice_discrete_leaf_count(float leaf_count, uint all) {
  float level_leaves = float(all);
  for (uint level = 1u; level < kCoppiceDiscreteLevels; level = level + 1u) {
    float coarser = ceil(0.25f * level_leaves);
    if (coarser < leaf_count) return level_leaves;
    level_leaves = coarser;
  }
  return level_leaves;
}

/// Whether a node belongs to cut(leaf_count): it exists (id < 2m - 1) and none of the first m - 1 splits replaced it.
/// node_split  the split that replaces the node, kCoppiceNoSplit if none does or it is not resident
COPPICE_FN bool coppice_node_alive(uint node, uint node_split, uint leaf_count) {
  return node < 2u * leaf_count - 1u && node_split >= leaf_count - 1u;
}

/// Error, px, of a wood LoD against the finest.
COPPICE_FN float coppice_wood_error_px(CoppiceTable table, uint lod, CoppiceColumn column) {
  return coppice_level_error_px(table, coppice_wood_row(table, lod), column);
}

/// The coarsest wood LoD whose error is at most kCoppiceWoodThresholdShare thresholds; 0, the finest, where there is none. wood_lod_count
/// must be > 0.
COPPICE_FN uint coppice_wood_lod(CoppiceTable table, CoppiceColumn column, float threshold_px) {
  uint lod = table.wood_lod_count - 1u;
  while (lod > 0u && coppice_wood_error_px(table, lod, column) > kCoppiceWoodThresholdShare * threshold_px) lod = lod - 1u;
  return lod;
}

/// The LoD to draw: the wanted one, else the nearest coarser one that is resident (the coarsest always is once uploaded), else the
/// nearest finer one. Bit i of the mask: LoD i is resident. wood_lod_count when the mask is empty.
COPPICE_FN uint coppice_resident_wood_lod(uint resident_mask, uint wanted, uint wood_lod_count) {
  for (uint lod = wanted; lod < wood_lod_count; lod = lod + 1u)
    if ((resident_mask & (1u << lod)) != 0u) return lod;
  for (uint lod = wanted; lod > 0u; lod = lod - 1u)
    if ((resident_mask & (1u << (lod - 1u))) != 0u) return lod - 1u;
  return wood_lod_count;
}

/// A well mixed 32-bit hash (PCG's output permutation over one LCG step).
COPPICE_FN uint coppice_hash(uint x) {
  uint state = x * 747796405u + 2891336453u;
  uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

/// The threshold of one instance: threshold_px * (1 +- kCoppiceThresholdSpread), fixed by the instance's index.
COPPICE_FN float coppice_instance_threshold_px(float threshold_px, uint instance) {
  float unit = float(coppice_hash(instance) >> 8u) * (1.0f / 16777216.0f);
  return threshold_px * (1.0f + kCoppiceThresholdSpread * (2.0f * unit - 1.0f));
}

#ifdef __cplusplus
}  // namespace coppice::lod
#endif

#endif
