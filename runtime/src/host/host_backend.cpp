#include "host_backend.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "plant_stream.h"

namespace coppice {
namespace {

/// A host's form: pages are their nodes, meshes are coppice_mesh_vertex[], then indices. The streamer counts the host's copies.
class HostForm final : public ChunkForm {
 public:
  [[nodiscard]] std::uint64_t reserved_bytes(std::uint64_t backend_bytes) const override { return backend_bytes; }
  [[nodiscard]] std::uint64_t page_bytes(std::uint64_t split_count) const override { return 2 * split_count * sizeof(PageNode); }

  [[nodiscard]] std::uint64_t mesh_bytes(gpu::MeshKind, const WoodShape& shape) const override {
    return shape.vertex_count * sizeof(coppice_mesh_vertex) + 3 * std::uint64_t{shape.triangle_count} * sizeof(std::uint32_t);
  }
  Result<gpu::MeshBlock> build_mesh(const PlantStream& plant, gpu::MeshKind kind, const WoodSpan& mesh) const override;
  [[nodiscard]] MeshLayout mesh_layout(const gpu::MeshBlock& block) const override {
    static_assert(offsetof(coppice_mesh_vertex, position) == 0);
    return {block.bytes.size() - block.index_count * sizeof(std::uint32_t), 0, sizeof(coppice_mesh_vertex)};
  }
};

Result<gpu::MeshBlock> HostForm::build_mesh(const PlantStream& plant, gpu::MeshKind, const WoodSpan& mesh) const {
  gpu::MeshBlock block;
  COPPICE_CHECK(
      allocate_into(block.bytes, plant.hooks.allocator, mesh.vertices.size() * sizeof(coppice_mesh_vertex) + mesh.indices.size_bytes()));
  block.low = block.high = mesh.vertices.empty() ? vec3{} : vec3(mesh.vertices[0].position);
  std::uint8_t* next = block.bytes.data();
  for (const WoodVertex& vertex : mesh.vertices) {
    coppice_mesh_vertex out{};
    std::ranges::copy(vertex.position, out.position);
    std::ranges::copy(vertex.normal, out.normal);
    std::ranges::copy(vertex.uv, out.uv);
    out.material = vertex.material;
    std::memcpy(next, &out, sizeof out);
    next += sizeof out;
    block.low = min(block.low, vec3(vertex.position));
    block.high = max(block.high, vec3(vertex.position));
  }
  std::memcpy(next, mesh.indices.data(), mesh.indices.size_bytes());
  block.index_count = static_cast<std::uint32_t>(mesh.indices.size());
  return block;
}

constexpr HostForm kHostForm{};

}  // namespace

Result<std::unique_ptr<Backend>> HostBackend::create(const BackendOptions& options) {
  constexpr std::uint32_t kMaxView_px = 1u << 20;
  std::unique_ptr<Backend> backend(new (std::nothrow)
                                       HostBackend({.max_instances = options.max_instances,
                                                    .max_plants = options.max_plants,
                                                    .max_view_width_px = kMaxView_px,
                                                    .max_view_height_px = kMaxView_px,
                                                    .sizes = {.form = &kHostForm, .block_textures = options.block_textures}}));
  if (!backend) return Error{Status::out_of_memory, "host"};
  return backend;
}

bool HostBackend::tell(const BackendEvent& event) {
  events_.push_back(event);
  return event.kind == COPPICE_CHANGE_CHUNK_DROPPED;
}

std::optional<BackendEvent> HostBackend::next_event() {
  if (events_.empty()) return std::nullopt;
  const BackendEvent event = events_.front();
  events_.pop_front();
  return event;
}

}  // namespace coppice
