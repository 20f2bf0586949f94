// A plant's cluster lists, names of an instance and one of its lists, and the leaves of a cluster that a cut shows. After bindings.glsl.

#include "coppice_light.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ClusterListArray { ClusterList at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ClusterArray { Cluster at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LeafArray { Leaf at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SplatArray { Splat at[]; };

// An item is an instance's slot and a list.
uint slot_of(uint item) { return item & (kMaxSlots - 1u); }
uint list_of(uint item) { return item >> kSlotBits; }

ClusterList list_at(Plant plant, uint list) { return ClusterListArray(plant.lists).at[list]; }
Cluster cluster_at(ClusterList list, uint cluster) {
  return ClusterArray(AddressArray(list.blocks).at[cluster / kBlockClusters]).at[cluster % kBlockClusters];
}

// A corner of a leaf in steps of its list's box.
vec3 quantised(uint corners[6], uint corner) {
  uint first = corner * 3;
  uvec3 q;
  for (uint axis = 0; axis < 3; ++axis) {
    uint half_word = first + axis;
    q[axis] = (corners[half_word >> 1] >> ((half_word & 1) * 16)) & 0xffffu;
  }
  return vec3(q);
}

// Fields of a splat. The normals are in object space.
float roughness_of(Splat splat) { return float(splat.axis >> 28u) * (1.0 / 15.0); }
LeafNormals normals_of(Splat splat) {
  return LeafNormals(unfold(unpackSnorm4x8(splat.normals).xy), float(splat.axis >> 24u & 15u) * (1.0 / 15.0), float(splat.look >> 31u));
}

uint leaf_count_of(Cluster cluster) { return cluster.counts & 255u; }
uint log2_grains(Cluster cluster) { return cluster.counts >> kCountGrains & 3u; }
bool is_surface(Cluster cluster) { return (cluster.counts >> kCountSurface & 1u) != 0; }

// The list for a cut of this many leaves.
uint ready_cut(uint leaf_count) { return min(coppice_ladder_rung(leaf_count), kReadyCuts - 1); }
uint list_of_cut(uint leaf_count) { return leaf_count > kReadyLeaves ? kPageList : ready_cut(leaf_count); }

// Number of leaves of a cut, and of an instance's cut.
uint whole_leaf_count(float cut, Plant plant) { return min(coppice_whole_leaf_count(cut), plant.resident_leaf_count); }
uint cut_leaf_count(uint slot, Plant plant) { return whole_leaf_count(cuts[slot], plant); }
// Number of clusters in the pages that bear some of a cut.
uint page_cluster_count(uint leaf_count) { return (leaf_count - 1 + kPageSplits - 1) / kPageSplits * kBlockClusters; }

// A cluster that bears leaves of a cut's last splits. Page 0 has one cluster for the first kReadyLeaves splits, and for each doubling as
// many again.
uint last_born_cluster(uint leaf_count) {
  uint first = page_cluster_count(leaf_count) - kBlockClusters, place = (leaf_count - 2) / kReadyLeaves;
  return first > 0 || place == 0 ? first : 1u << findMSB(place);
}

// Number of splits of a cluster's page that a cut of the pages includes.
uint born_splits(uint leaf_count, uint cluster) {
  uint first = cluster / kBlockClusters * kPageSplits;
  return min(leaf_count - 1 - min(leaf_count - 1, first), kPageSplits);
}
bool is_born(uint life, uint splits) { return life >> kBirthShift < splits; }

// True if a leaf of a cut is a source leaf and stands for no others. finest: a ready cut has all leaves
bool is_single(Leaf leaf, bool paged, bool finest) { return paged ? (leaf.life & kNoDeath) == kNoDeath : finest; }

// The leaves of a cluster that are drawn: its first `count`; if not all of them are born yet, each leaf is tested.
struct ShownLeaves {
  uint count;
  bool partly_born;
};

ShownLeaves all_shown(Cluster cluster) { return ShownLeaves(leaf_count_of(cluster), false); }

ShownLeaves shown_of_page(Cluster cluster, uint index, uint leaf_count) {
  uint splits = born_splits(leaf_count, index), high = leaf_count_of(cluster);
  bool none = high == 0 || (cluster.counts >> kCountFirstBirth & 511u) >= splits || cluster.last_death < leaf_count - 1;
  if (none) return ShownLeaves(0, false);
  // The first leaf is alive, because its death is the last one.
  uint low = 1;
  while (low < high) {
    uint middle = (low + high + 1) / 2;
    bool alive = (LeafArray(cluster.leaves).at[middle - 1].life & kNoDeath) >= leaf_count - 1;
    low = alive ? middle : low;
    high = alive ? high : middle - 1;
  }
  return ShownLeaves(low, (cluster.counts >> kCountLastBirth & 511u) >= splits);
}

// The quarter whose lengths describe the shown leaves: dead leaves may be much larger, unborn ones smaller.
uint shown_quarter(ShownLeaves shown) { return shown.partly_born ? 3 : max(4 * shown.count / kClusterLeaves, 1) - 1; }

// About how many those are; the mean is right.
uint drawn_count(ShownLeaves shown, Cluster cluster, uint splits) {
  uint first = cluster.counts >> kCountFirstBirth & 511u, last = cluster.counts >> kCountLastBirth & 511u;
  return shown.partly_born ? (shown.count * (splits - first) + (last - first)) / (last - first + 1) : shown.count;
}
