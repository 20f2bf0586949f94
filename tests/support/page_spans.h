#pragma once

// Nodes of a plant as the rasteriser's lists find them: page by page.

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "raster_shared.h"
#include "tree.h"

namespace coppice::test {

/// nodes: from node 0 on, which is in no page; they stay where they are
inline std::vector<SharedNodes> page_spans(std::span<const PageNode> nodes) {
  std::vector<SharedNodes> pages;
  for (std::size_t first = 1; first < nodes.size(); first += gpu::kPageNodes)
    pages.push_back({nodes.subspan(first, std::min<std::size_t>(gpu::kPageNodes, nodes.size() - first)), nullptr});
  return pages;
}

}  // namespace coppice::test
