#include "page_clusters.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "card_looks.h"
#include "check.h"
#include "coppice_lod.h"
#include "coppice_transparency.h"

namespace coppice::gpu {
namespace {

static_assert(kReadyLeaves <= kClusterLeaves && kPageNodes == 2 * kPageSplits && kBlockClusters <= 32);

/// True if it is only alive in cuts of up to this many leaves, which ready cuts show.
bool is_only_in_ready_cuts(std::uint32_t split) {
  return split < kReadyLeaves;
}

uvec3 words_of(const QuantisedPoint& corner) {
  return {corner[0], corner[1], corner[2]};
}

/// The mean over directions d of exp(-dot(slope, d)). Depth is nowhere below 0, so it cannot be steeper than its mean.
float slope_gain(float depth, const vec3& slope) {
  const float steepness = std::min(length(slope), depth);
  return steepness > 1e-3f ? std::sinh(steepness) / steepness : 1.0f;
}

/// The mean light of three places on the leaf, from end to end. The eye sees as much of each as light reaches it.
CrownSample light_of(const CrownLight& light, const LeafEntry& entry) {
  CrownSample mean{};
  float seen = 0, lit = 0;
  for (const float along : {-0.8f, 0.0f, 0.8f}) {
    const CrownSample sample = light.at(entry.middle() + 0.5f * along * (entry.axis[1] - entry.axis[0]));
    const float open = std::exp(-sample.depth) * slope_gain(sample.depth, sample.slope);
    mean.slope += open * open * sample.slope;
    mean.sky += open * sample.sky;
    seen += open;
    lit += open * open;
  }
  mean.slope = mean.slope / vec3(lit);
  mean.sky /= seen;
  // As much of the sun, in the mean over its directions, as the places have.
  mean.depth = -std::log(lit / seen);
  mean.depth += std::log(slope_gain(mean.depth, mean.slope));
  return mean;
}

/// Fills all words of a node but `life`.
LeafEntry entry_of(const LeafSource& source, const PageNode& node, std::uint32_t id) {
  const Crown crown = crown_of(source.box);
  std::array<uvec3, 4> corners;
  std::ranges::transform(node.corners, corners.begin(), words_of);
  LeafEntry entry = make_entry(corners, source.box);
  const CardLook& look = source.looks[node.card];
  const auto& c = entry.corners;
  entry.id = id;
  entry.transparency = transparency_of(node.opacity);
  entry.leaf.card = node.card | entry.transparency << kTransparencyShift;
  const vec3 across = cross(c[2] - c[0], c[3] - c[1]);
  entry.face = dot(across, across) > 1e-20f ? normalize(across) : vec3(0.0f, 1.0f, 0.0f);
  const ShadingNormals normals = unpack_normals(node.normals, {entry.face.x, entry.face.y, entry.face.z});
  entry.normals = {vec3(normals.axis), normals.along, normals.is_sided ? 1.0f : 0.0f};
  entry.roughness = look.roughness;
  entry.look = pack_albedo(look.albedo * variation(crown, c[0], corners[0]));
  entry.covered_m2 = covered_area_m2(entry.area_m2, look, node.opacity);
  entry.light = light_of(*source.light, entry);
  return entry;
}

/// Splits places [0, order.size()) of `order` into runs of kClusterLeaves (the last may be shorter), by halving along the longest side.
void order_by_place(std::span<const vec3> middles, std::span<std::uint16_t> order) {
  const std::size_t cluster_count = (order.size() + kClusterLeaves - 1) / kClusterLeaves;
  if (cluster_count < 2) return;
  vec3 low = middles[order[0]], high = low;
  for (const std::uint16_t at : order) {
    low = min(low, middles[at]);
    high = max(high, middles[at]);
  }
  const vec3 size = high - low;
  const std::size_t longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::size_t half = cluster_count / 2 * kClusterLeaves;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(), [&](std::uint16_t a, std::uint16_t b) {
    return middles[a][longest] != middles[b][longest] ? middles[a][longest] < middles[b][longest] : a < b;
  });
  order_by_place(middles, order.subspan(0, half));
  order_by_place(middles, order.subspan(half));
}

/// Writes the parts of a block of clusters.
class BlockWriter {
 public:
  /// leaf_room: capacity for leaves
  BlockWriter(std::span<std::uint8_t> out, std::size_t clusters_at, std::size_t cluster_room, std::size_t leaf_room)
      : out_(out),
        cluster_room_(cluster_room),
        clusters_at_(clusters_at),
        leaves_at_(clusters_at + cluster_room * sizeof(Cluster)),
        splats_at_(leaves_at_ + leaf_room * sizeof(Leaf)) {}

  void add(std::span<const LeafEntry> entries, const Births& births, const LeafBox& box) {
    std::array<Leaf, kClusterLeaves> leaves;
    std::array<Splat, kClusterLeaves> splats;
    Cluster cluster = write_cluster(entries, births, box, leaves, splats);
    cluster.leaves.x = static_cast<std::uint32_t>(leaves_at_);
    cluster.splats.x = static_cast<std::uint32_t>(splats_at_);
    COPPICE_ASSERT(cluster_room_-- > 0);
    put(clusters_at_, &cluster, sizeof cluster);
    put(leaves_at_, leaves.data(), entries.size() * sizeof(Leaf));
    put(splats_at_, splats.data(), entries.size() * sizeof(Splat));
  }

 private:
  void put(std::size_t& at, const void* data, std::size_t bytes) {
    COPPICE_ASSERT(at + bytes <= out_.size());
    std::memcpy(out_.data() + at, data, bytes);
    at += bytes;
  }

  std::span<std::uint8_t> out_;
  std::size_t cluster_room_, clusters_at_, leaves_at_, splats_at_;
};

/// Writes clusters of places that are close together. entry_at(place): the leaf there
template <class EntryAt, class Less>
void add_clusters(BlockWriter& writer, ClusterScratch& scratch, std::span<std::uint16_t> order, const LeafBox& box, const EntryAt& entry_at,
                  const Less& less, bool in_page) {
  order_by_place(scratch.middles, order);
  for (std::size_t first = 0; first < order.size(); first += kClusterLeaves) {
    const std::span<std::uint16_t> members = order.subspan(first, std::min<std::size_t>(kClusterLeaves, order.size() - first));
    const std::span<LeafEntry> entries(scratch.entries.data(), members.size());
    std::ranges::transform(members, entries.begin(), entry_at);
    std::ranges::sort(entries, less);
    const auto [low, high] = std::ranges::minmax(members);
    writer.add(entries, in_page ? Births{low / 2u, high / 2u} : Births{}, box);
  }
}

vec3 middle_of(const LeafBox& box, const PageNode& node) {
  vec3 sum(0.0f);
  for (const QuantisedPoint& corner : node.corners) sum += box.at(words_of(corner));
  return sum * 0.25f;
}

}  // namespace

void build_page(const LeafSource& source, std::uint32_t page, std::span<const PageNode> nodes, ClusterScratch& scratch,
                std::span<std::uint8_t> out) {
  COPPICE_ASSERT(out.size() == kPageBytes && nodes.size() <= kPageNodes);
  std::ranges::fill(out, std::uint8_t{0});
  for (std::size_t place = 0; place < nodes.size(); ++place) scratch.middles[place] = middle_of(source.box, nodes[place]);
  const auto life = [&](std::size_t place) {
    return static_cast<std::uint32_t>(place / 2) << kBirthShift | std::min(nodes[place].split, kNoDeath);
  };
  const auto entry_at = [&](std::uint16_t place) {
    LeafEntry entry = entry_of(source, nodes[place], kPageNodes * page + 1 + place);
    entry.leaf.life = life(place);
    return entry;
  };
  // Leaves that die last come first, so that the living ones among those born come first. Leaves with the same death are ordered by size,
  // because neighbours then take equally long.
  const auto less = [](const LeafEntry& a, const LeafEntry& b) {
    const std::uint32_t one = a.leaf.life & kNoDeath, other = b.leaf.life & kNoDeath;
    return one != other ? one > other : a.size_m != b.size_m ? a.size_m > b.size_m : a.id < b.id;
  };
  BlockWriter writer(out, 0, kBlockClusters, kPageNodes);
  // Page 0 serves cuts that show only a part of its leaves. Its clusters double in size, so that leaves not born yet are skipped with their
  // cluster.
  for (std::size_t first = 0, leaves = kReadyLeaves; first < nodes.size(); leaves *= 2) {
    const std::size_t end = page == 0 ? std::min(2 * leaves, nodes.size()) : nodes.size();
    std::uint16_t count = 0;
    for (; first < end; ++first)
      if (!is_only_in_ready_cuts(nodes[first].split)) scratch.order[count++] = static_cast<std::uint16_t>(first);
    if (count > 0) add_clusters(writer, scratch, std::span(scratch.order).first(count), source.box, entry_at, less, true);
  }
}

bool has_transparency(std::span<const std::uint8_t> page) {
  for (std::size_t i = 0; i < kBlockClusters; ++i) {
    Cluster cluster;
    std::memcpy(&cluster, page.data() + i * sizeof cluster, sizeof cluster);
    if ((cluster.counts >> kCountTransparent & 1u) != 0) return true;
  }
  return false;
}

namespace {

/// Number of leaves in a ready cut: the ladder's, or all.
std::uint32_t ready_leaf_count(std::uint32_t cut, std::uint32_t leaf_count) {
  return std::min(lod::coppice_ladder_leaf_count(cut), leaf_count);
}

/// True if the cut before is the same.
bool repeats(std::uint32_t cut, std::uint32_t leaf_count) {
  return cut > 0 && ready_leaf_count(cut, leaf_count) == ready_leaf_count(cut - 1, leaf_count);
}

std::size_t cut_bytes(std::uint32_t leaves) {
  return sizeof(uvec2) + sizeof(Cluster) + leaves * (sizeof(Leaf) + sizeof(Splat));
}

}  // namespace

std::size_t ready_cut_bytes(std::uint32_t leaf_count) {
  std::size_t bytes = 0;
  for (std::uint32_t cut = 0; cut < kReadyCuts; ++cut)
    if (!repeats(cut, leaf_count)) bytes += cut_bytes(ready_leaf_count(cut, leaf_count));
  return bytes;
}

void build_ready_cuts(const LeafSource& source, std::span<const PageNode> page_0, ClusterScratch& scratch, ReadyCuts& cuts) {
  const std::span<std::uint8_t> out = cuts.bytes.span();
  auto& lists = cuts.lists;
  COPPICE_ASSERT(out.size() == ready_cut_bytes(source.leaf_count));
  const auto node = [&](std::uint32_t id) -> const PageNode& { return id == 0 ? source.root : page_0[id - 1]; };
  const auto transparent = [](const PageNode& of) { return transparency_of(of.opacity) > 0; };
  cuts.has_transparency = transparent(source.root) || std::ranges::any_of(page_0, transparent);
  const auto entry_at = [&](std::uint16_t id) { return entry_of(source, node(id), id); };
  const auto larger = [](const LeafEntry& a, const LeafEntry& b) { return a.size_m != b.size_m ? a.size_m > b.size_m : a.id < b.id; };
  std::size_t at = 0;
  for (std::uint32_t cut = 0; cut < kReadyCuts; ++cut) {
    if (repeats(cut, source.leaf_count)) {
      lists[cut] = lists[cut - 1];
      continue;
    }
    const std::uint32_t leaves = ready_leaf_count(cut, source.leaf_count);
    std::uint16_t count = 0;
    for (std::uint32_t id = 0; id < 2 * leaves - 1; ++id) {
      if (!lod::coppice_node_alive(id, node(id).split, leaves)) continue;
      scratch.middles[id] = middle_of(source.box, node(id));
      scratch.order[count++] = static_cast<std::uint16_t>(id);
    }
    const std::size_t cluster_at = at + sizeof(uvec2);
    const uvec2 block{static_cast<std::uint32_t>(cluster_at), 0};
    std::memcpy(out.data() + at, &block, sizeof block);
    BlockWriter writer(out, cluster_at, 1, leaves);
    add_clusters(writer, scratch, std::span(scratch.order).first(count), source.box, entry_at, larger, false);
    ClusterList& list = lists[cut];
    list = empty_list(source.box);
    list.leaf_count = leaves;
    list.cluster_count = 1;
    list.blocks.x = static_cast<std::uint32_t>(at);
    Cluster cluster;
    std::memcpy(&cluster, out.data() + cluster_at, sizeof cluster);
    list.grain_m = unpack_length(cluster.grains_m, 3);
    list.leaf_size_m = unpack_length(cluster.leaf_sizes_m, 3);
    at += cut_bytes(leaves);
  }
}

void move_ready_cuts(std::uint32_t leaf_count, std::span<ClusterList, kReadyCuts> lists, std::span<std::uint8_t> bytes,
                     std::uint64_t base) {
  for (std::uint32_t cut = 0; cut < kReadyCuts; ++cut) {
    ClusterList& list = lists[cut];
    if (repeats(cut, leaf_count)) {
      list.blocks = lists[cut - 1].blocks;
      continue;
    }
    const std::span<std::uint8_t> own = bytes.subspan(list.blocks.x);
    uvec2 block{};
    std::memcpy(&block, own.data(), sizeof block);
    move_address(block, base);
    std::memcpy(own.data(), &block, sizeof block);
    move_clusters(own.subspan(sizeof block), list.cluster_count, base);
    move_address(list.blocks, base);
  }
}

void move_address(uvec2& address, std::uint64_t base) {
  const std::uint64_t moved = base + (address.x | std::uint64_t{address.y} << 32);
  address = {static_cast<std::uint32_t>(moved), static_cast<std::uint32_t>(moved >> 32)};
}

void move_clusters(std::span<std::uint8_t> bytes, std::size_t cluster_count, std::uint64_t base) {
  for (std::size_t i = 0; i < cluster_count; ++i) {
    Cluster cluster;
    std::memcpy(&cluster, bytes.data() + i * sizeof cluster, sizeof cluster);
    move_address(cluster.leaves, base);
    move_address(cluster.splats, base);
    std::memcpy(bytes.data() + i * sizeof cluster, &cluster, sizeof cluster);
  }
}

}  // namespace coppice::gpu
