#pragma once

// The lists the compute rasteriser draws from: one per rung of a ladder of cuts, shared by every instance that shows about so many leaves,
// one per wood LoD and one per chunk of leaf meshes. A list holds the leaves of cut(m) and nothing else, neighbours together in clusters of
// kClusterLeaves that are culled as one; inside a cluster the leaves are sorted by size, because invocations side by side take as long as
// the slowest.

#include <cstdint>
#include <span>
#include <vector>

#include "card_looks.h"
#include "crown_light.h"
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

/// What a cut is built from.
struct LeafSource {
  PageNode root;
  std::span<const SharedNodes> pages;  ///< kPageNodes nodes each, but for the last: nodes 1 .. 2m - 2 or more
  std::span<const RasterCard> looks;   ///< of the cards
  LeafBox box;
  const CrownLight& light;
  std::uint32_t plant_leaf_count = 1;  ///< of the whole plant

  [[nodiscard]] const PageNode& node(std::uint32_t id) const {
    return id == 0 ? root : pages[(id - 1) / kPageNodes].nodes[(id - 1) % kPageNodes];
  }
};

/// The leaves of cut(leaf_count). 1 <= leaf_count <= N
BuiltList build_leaf_list(const LeafSource& source, std::uint32_t leaf_count);

/// The triangles of a wood LoD, quantised to 1/65535 of the mesh's box; those that are nothing but hole are left out.
struct WoodSource {
  const PlantLooks& looks;  ///< with what triangle_look needs of the mesh's materials that are masked
  const CrownLight& light;
};
BuiltList build_wood_list(const WoodMesh& mesh, const WoodSource& source);

/// The triangles of a chunk of leaf meshes, likewise; none where holes in their texture make the leaves' outline.
struct LeafMeshSource {
  const PlantLooks& looks;  ///< with what triangle_look needs of the mesh's materials
  LeafBox box;
  const CrownLight& light;
};
BuiltList build_leaf_mesh_list(const WoodMesh& mesh, const LeafMeshSource& source);

}  // namespace coppice::gpu
