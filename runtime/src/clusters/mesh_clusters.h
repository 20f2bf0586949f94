#pragma once

// Turns wood LoDs and chunks of leaf meshes into the form in which they are drawn: indices and vertices, and clusters of their triangles,
// so that a renderer can cull parts of them, and draw small triangles as leaves. Knows no Vulkan. Any thread.

#include <array>
#include <bitset>
#include <cstdint>

#include "card_looks.h"
#include "coppice_shared.h"
#include "hooks.h"
#include "wood_codec.h"

namespace coppice::gpu {

enum class MeshKind : std::uint8_t { wood, leaves };

/// Input that all meshes of a plant share.
struct MeshSource {
  PlantAppearance appearance;
  LeafBox box;
  bool leaves = true;  ///< false if nobody draws small triangles as leaves
};

/// A mesh in one run of bytes: uint32 indices, then WoodVertex[] or LeafMeshVertex[], then from clusters_at on its clusters: addresses of
/// blocks, Cluster[], Leaf[], Splat[]. Indices come first because lavapipe (Mesa 22.3) ignores the offset of vkCmdBindIndexBuffer in
/// indirect draws.
struct MeshBlock {
  HookBuffer bytes;
  std::uint32_t index_count = 0;
  std::size_t vertices_at = 0, clusters_at = 0;
  ClusterList list{};                            ///< cluster_count is 0 if small triangles are not drawn as leaves
  std::bitset<COPPICE_MAX_MATERIALS> materials;  ///< those that its vertices use
  vec3 low{}, high{};                            ///< bounds of its vertices; object space, m

  /// Adds `base` to all addresses, which count from the start of `bytes` before.
  void move(std::uint64_t base);
};

/// Positions of leaves are quantised to 1/65535 of the mesh's box. Triangles that consist of holes are not drawn as leaves. If holes in a
/// leaf mesh's texture form the outline of its leaves, no triangle is. Indices are in the order of the clusters. errors  out_of_memory
Result<MeshBlock> build_mesh(MeshKind kind, const WoodSpan& mesh, const MeshSource& source, const coppice_allocator& allocator);

/// Maximum length of a block for these counts. leaves: MeshSource::leaves
std::uint64_t max_mesh_bytes(MeshKind kind, std::uint64_t vertex_count, std::uint64_t triangle_count, bool leaves);
/// Temporary memory of build_mesh.
std::uint64_t mesh_scratch_bytes(std::uint64_t triangle_count);

}  // namespace coppice::gpu
