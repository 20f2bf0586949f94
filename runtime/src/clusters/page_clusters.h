#pragma once

// Turns a plant's leaves into the form in which they are drawn. Pages become clusters of leaves that are close in space. A few coarse cuts
// become clusters of their own, which all far plants share. A node belongs to the clusters of one page, whichever cut it is drawn in:
// cut(m) draws those nodes of a page that are born before split m - 1 and not replaced by then.
//
// No function here allocates, and none knows Vulkan. Any thread.

#include <array>
#include <cstdint>
#include <span>

#include "crown_light.h"
#include "hooks.h"
#include "leaf_entry.h"
#include "tree.h"

namespace coppice::gpu {

/// Input for clusters of leaves.
struct LeafSource {
  PageNode root;
  std::span<const CardLook> looks;  ///< those of the cards
  LeafBox box;
  const CrownLight* light = nullptr;  ///< measured from page 0
  std::uint32_t leaf_count = 1;       ///< leaves of the whole plant
};

/// Working memory of a build.
struct ClusterScratch {
  std::array<vec3, kPageNodes> middles;
  std::array<std::uint16_t, kPageNodes> order;
  std::array<LeafEntry, kClusterLeaves> entries;
};

/// A page on the device: Cluster[kBlockClusters], Leaf[kPageNodes], Splat[kPageNodes].
inline constexpr std::size_t kPageBytes = kBlockClusters * sizeof(Cluster) + kPageNodes * (sizeof(Leaf) + sizeof(Splat));

/// Writes a page's clusters. Nodes that only ready cuts show are left out. nodes: the page's, [2 * its splits]. out: [kPageBytes];
/// addresses count from its start.
void build_page(const LeafSource& source, std::uint32_t page, std::span<const PageNode> nodes, ClusterScratch& scratch,
                std::span<std::uint8_t> out);

/// True if leaves of a page are transparent. page: [kPageBytes] of build_page
bool has_transparency(std::span<const std::uint8_t> page);

/// Length of a plant's ready cuts.
std::size_t ready_cut_bytes(std::uint32_t leaf_count);
/// A plant's coarse cuts. Addresses, also those of the lists, count from the start of `bytes`.
struct ReadyCuts {
  std::array<ClusterList, kReadyCuts> lists{};
  HookBuffer bytes;               ///< [ready_cut_bytes]
  bool has_transparency = false;  ///< true if nodes that they may show are transparent
};
/// page_0: as in build_page; empty for a plant of one leaf. cuts: its bytes are allocated
void build_ready_cuts(const LeafSource& source, std::span<const PageNode> page_0, ClusterScratch& scratch, ReadyCuts& cuts);

/// Adds `base` to the addresses, once the memory is known.
void move_ready_cuts(std::uint32_t leaf_count, std::span<ClusterList, kReadyCuts> lists, std::span<std::uint8_t> bytes, std::uint64_t base);
/// Does this for the clusters at the start of `bytes`.
void move_clusters(std::span<std::uint8_t> bytes, std::size_t cluster_count, std::uint64_t base);
void move_address(uvec2& address, std::uint64_t base);

}  // namespace coppice::gpu
