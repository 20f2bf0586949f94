#pragma once

// Walks the leaves of a cut, which lie in pages.

#include <algorithm>
#include <cstdint>
#include <span>

#include "coppice_lod.h"
#include "page_codec.h"
#include "streamer.h"

namespace coppice {

/// Calls take(node) for the nodes of cut(leaf_count), ascending. file: an open index. leaf_count: at most the resident number
template <class Take>
void for_each_leaf(const Streamer& streamer, std::uint32_t file, std::uint32_t leaf_count, const Take& take) {
  if (leaf_count == 0) return;
  const auto alive = [leaf_count](std::uint32_t node, std::uint32_t split) { return lod::coppice_node_alive(node, split, leaf_count); };
  const PageNode root = root_node(streamer.file(file).plant);
  if (alive(0, root.split)) take(root);
  const std::uint32_t end = 2 * leaf_count - 1;
  constexpr std::uint32_t kPageNodeCount = 2 * COPPICE_PAGE_SPLITS;
  for (std::uint32_t first = 1; first < end; first += kPageNodeCount) {
    const std::span<const PageNode> nodes = streamer.page_nodes(file, first / kPageNodeCount);
    const std::uint32_t count = std::min(end - first, static_cast<std::uint32_t>(nodes.size()));
    for (std::uint32_t i = 0; i < count; ++i)
      if (alive(first + i, nodes[i].split)) take(nodes[i]);
  }
}

}  // namespace coppice
