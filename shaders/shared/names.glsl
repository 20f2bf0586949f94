// Names in the rasteriser's lists and pixels. After clusters.glsl.

// A word that names a cluster of an item's list, and how many of its leaves are shown, at least one.
uint work_of(uint cluster, ShownLeaves shown) {
  return cluster | (shown.count - 1) << kClusterBits | (shown.partly_born ? 1u << 31 : 0u);
}
uint cluster_of_work(uint work) { return work & ((1u << kClusterBits) - 1u); }
ShownLeaves shown_of_work(uint work) { return ShownLeaves((work >> kClusterBits & (kClusterLeaves - 1u)) + 1, work >> 31 != 0); }

// Includes the share of the sun that gets past other plants.
WorkItem work_item(uint item, uint work, Cluster cluster, float sun) {
  return WorkItem(item, work, uvec2(cluster.splats.x, cluster.splats.y | uint(float(kWorkSunSteps) * sun + 0.5) << kWorkSunShift));
}
uvec2 splats_of_work(WorkItem work) { return uvec2(work.splats.x, work.splats.y & ((1u << kWorkSunShift) - 1u)); }
float sun_of_work(WorkItem work) { return float(work.splats.y >> kWorkSunShift) / float(kWorkSunSteps); }

// Number of leaves in the cut that an item belongs to: that of its list, or of the instance.
uint item_leaf_count(uint item, Plant plant, ClusterList list) {
  return list_of(item) == kPageList ? cut_leaf_count(slot_of(item), plant) : list.leaf_count;
}

// A pixel's name, above 0. The low bits are the index of its cluster in work_items, from 1 on, which differs between drawings of a picture.
// The bits above are its leaf, shifted by a number of the cluster's own. Of leaves at exactly the same depth the larger name wins, so the
// same leaf wins each time unless all of those bits agree.
uint first_name(uint place, WorkItem work, uint place_bits) {
  return coppice_hash(work.item ^ cluster_of_work(work.work) * 2654435769u) << place_bits | (place + 1);
}
uint name_of_leaf(uint first, uint leaf, uint place_bits) { return first + (leaf << place_bits); }
uint place_of_name(uint name, uint place_bits) { return (name & ((1u << place_bits) - 1u)) - 1; }
// first: first_name of its place
uint leaf_of_name(uint name, uint first, uint place_bits) { return (name - first) >> place_bits & (kClusterLeaves - 1u); }
