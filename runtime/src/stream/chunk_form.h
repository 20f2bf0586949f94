#pragma once

// The form in which a backend takes pages and meshes, and the memory that they take there. The renderer takes clusters. A host that draws
// itself takes nodes and plain meshes (host/host_backend.cpp).

#include <cstddef>
#include <cstdint>

#include "mesh_clusters.h"
#include "wood_codec.h"

namespace coppice {

struct PageData;
struct PlantStream;
struct Transfer;

/// Positions of a mesh in its block, bytes: uint32 indices, and vertices that begin with their place.
struct MeshLayout {
  std::size_t indices = 0, vertices = 0, vertex_bytes = 0;
};

/// Jobs call prepare_page, build_page and build_mesh, at the same time for different chunks; the frame's thread calls the rest.
class ChunkForm {
 public:
  ChunkForm() = default;
  ChunkForm(const ChunkForm&) = delete;
  ChunkForm& operator=(const ChunkForm&) = delete;

  /// The part of a chunk's memory in the backend that the streamer reserves; the backend reserves the rest itself.
  [[nodiscard]] virtual std::uint64_t reserved_bytes(std::uint64_t backend_bytes) const = 0;

  /// Memory of a page in the backend.
  [[nodiscard]] virtual std::uint64_t page_bytes(std::uint64_t split_count) const = 0;
  /// Memory of a decoded page beside its nodes until it is uploaded. Takes the page, and the plant's leaf count.
  [[nodiscard]] virtual std::uint64_t page_upload_bytes(std::uint32_t, std::uint32_t) const { return 0; }
  /// Allocates that memory for the transfer's page, in `data`, and what build_page needs. errors  out_of_memory
  virtual Result<void> prepare_page(PlantStream&, Transfer&, PageData&) const { return {}; }
  /// Fills it from the nodes of the transfer's page.
  virtual void build_page(PlantStream&, Transfer&) const {}

  /// Maximum length of a mesh's block.
  [[nodiscard]] virtual std::uint64_t mesh_bytes(gpu::MeshKind kind, const WoodShape& shape) const = 0;
  /// Temporary memory of build_mesh for a number of triangles.
  [[nodiscard]] virtual std::uint64_t mesh_scratch_bytes(std::uint32_t) const { return 0; }
  /// errors  out_of_memory
  virtual Result<gpu::MeshBlock> build_mesh(const PlantStream& plant, gpu::MeshKind kind, const WoodSpan& mesh) const = 0;
  [[nodiscard]] virtual MeshLayout mesh_layout(const gpu::MeshBlock& block) const = 0;

 protected:
  ~ChunkForm() = default;
};

/// The renderer's form. mesh_leaves: gpu::MeshSource::leaves
const ChunkForm& cluster_form(bool mesh_leaves);

}  // namespace coppice
