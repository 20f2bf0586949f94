#pragma once

// Wood LoDs and chunks of leaf meshes as whoever draws them takes them: indices and vertices, and clusters of their triangles, for whoever
// draws what of them is in view, or small ones as leaves are drawn. Knows no Vulkan. Any thread.

#include <array>
#include <bitset>
#include <cstdint>

#include "card_looks.h"
#include "coppice_shared.h"
#include "hooks.h"
#include "wood_codec.h"

namespace coppice::gpu {

enum class MeshKind : std::uint8_t { wood, leaves };

/// What all meshes of a plant are made with.
struct MeshSource {
  PlantAppearance appearance;
  LeafBox box;
  bool leaves = true;  ///< or nobody draws small triangles as leaves
};

/// A mesh in one run of bytes: uint32 indices, then WoodVertex[] or LeafMeshVertex[], then, from clusters_at on, its clusters: addresses of
/// blocks, Cluster[], Leaf[], Splat[]. In this order because lavapipe (Mesa 22.3) ignores the offset of vkCmdBindIndexBuffer in indirect
/// draws.
struct MeshBlock {
  HookBuffer bytes;
  std::uint32_t index_count = 0;
  std::size_t vertices_at = 0, clusters_at = 0;
  ClusterList list{};                            ///< no cluster_count: small triangles are not to be drawn as leaves
  std::bitset<COPPICE_MAX_MATERIALS> materials;  ///< of its vertices
  vec3 low{}, high{};                            ///< of its vertices; object space, m

  /// All addresses, which count from the start of `bytes`, are moved there.
  void move(std::uint64_t base);
};

/// Positions of leaves are quantised to 1/65535 of the mesh's box. Triangles that are nothing but hole are not drawn as leaves; none are
/// where holes in a leaf mesh's texture make the leaves' outline. Indices are in the order of the clusters. errors  out_of_memory
Result<MeshBlock> build_mesh(MeshKind kind, const WoodSpan& mesh, const MeshSource& source, const coppice_allocator& allocator);

/// No block of so many is longer. leaves: MeshSource's
std::uint64_t most_mesh_bytes(MeshKind kind, std::uint64_t vertex_count, std::uint64_t triangle_count, bool leaves);
/// What build_mesh takes besides while it runs.
std::uint64_t mesh_scratch_bytes(std::uint64_t triangle_count);

}  // namespace coppice::gpu
