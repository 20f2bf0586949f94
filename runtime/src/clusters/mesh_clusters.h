#pragma once

// The triangles of wood LoDs and of leaf meshes as clusters, for whoever draws small ones as leaves are drawn.

#include <cstdint>
#include <vector>

#include "card_looks.h"
#include "coppice_shared.h"
#include "crown_light.h"
#include "wood_codec.h"

namespace coppice::gpu {

/// A list as it is copied to the device. Addresses in `bytes` and of the list count from the start of `bytes`, which begin with those of
/// blocks of clusters; then come the clusters.
struct MeshClusters {
  ClusterList list{};  ///< no leaves: its triangles are not to be drawn so
  std::vector<std::uint8_t> bytes;

  /// They are at `base` after all.
  void move(std::uint64_t base);
};

/// The triangles of a wood LoD, quantised to 1/65535 of the mesh's box; those that are nothing but hole are left out.
struct WoodSource {
  const PlantLooks& looks;  ///< with what triangle_look needs of the mesh's materials that are masked
  const CrownLight& light;
};
MeshClusters build_wood(const WoodMesh& mesh, const WoodSource& source);

/// The triangles of a chunk of leaf meshes, likewise; none where holes in their texture make the leaves' outline.
struct LeafMeshSource {
  const PlantLooks& looks;  ///< with what triangle_look needs of the mesh's materials
  LeafBox box;
  const CrownLight& light;
};
MeshClusters build_leaf_mesh(const WoodMesh& mesh, const LeafMeshSource& source);

/// No list of so many triangles is longer.
std::uint64_t most_mesh_cluster_bytes(std::uint64_t triangle_count);

}  // namespace coppice::gpu
