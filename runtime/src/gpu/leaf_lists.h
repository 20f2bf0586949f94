#pragma once

// The lists the compute rasteriser draws from: one per rung of a ladder of cuts, shared by every instance that shows about so many leaves,
// and one per wood LoD. A list holds the leaves of cut(m) and nothing else, neighbours together in clusters of kClusterLeaves that are
// culled as one; inside a cluster the leaves are sorted by size, because invocations side by side take as long as the slowest.

#include <cstdint>
#include <span>
#include <vector>

#include "raster_shared.h"
#include "tree.h"
#include "wood_codec.h"

namespace coppice::gpu {

/// A list as it is copied to the device; the header's addresses are zero.
struct BuiltList {
  RasterList header{};
  std::vector<RasterCluster> clusters;
  std::vector<RasterLeaf> leaves;
  std::vector<RasterSplat> splats;  ///< the same leaves
};

/// What leaf corners are quantised in: min + step * q, q <= largest. Object space, m.
struct LeafBox {
  vec3 min{}, step{};
  std::uint32_t largest = 1;
};

/// The nodes that are resident.
struct LeafSource {
  PageNode root;
  std::span<const std::span<const PageNode>> pages;  ///< kPageNodes nodes each, but for the last: nodes 1 .. 2m - 2 or more
  std::span<const RasterCard> looks;                 ///< of the cards
  LeafBox box;

  [[nodiscard]] const PageNode& node(std::uint32_t id) const {
    return id == 0 ? root : pages[(id - 1) / kPageNodes][(id - 1) % kPageNodes];
  }
};

/// The leaves of cut(leaf_count). 1 <= leaf_count <= N
BuiltList build_leaf_list(const LeafSource& source, std::uint32_t leaf_count);

/// The triangles of a wood LoD, quantised to 1/65535 of the mesh's box.
/// first_material  among the plant's RasterCards. box: the leaves'
struct WoodSource {
  std::uint32_t first_material = 0;
  LeafBox crown;
};
BuiltList build_wood_list(const WoodMesh& mesh, const WoodSource& source);

}  // namespace coppice::gpu
