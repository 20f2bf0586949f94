#include "chunk_form.h"

#include "plant_stream.h"

namespace coppice {
namespace {

class ClusterForm final : public ChunkForm {
 public:
  explicit constexpr ClusterForm(bool mesh_leaves) : mesh_leaves_(mesh_leaves) {}

  [[nodiscard]] std::uint64_t reserved_bytes(std::uint64_t) const override { return 0; }
  [[nodiscard]] std::uint64_t page_bytes(std::uint64_t) const override { return gpu::kPageBytes; }
  [[nodiscard]] std::uint64_t page_upload_bytes(std::uint32_t page, std::uint32_t leaf_count) const override {
    return gpu::kPageBytes + (page == 0 ? gpu::ready_cut_bytes(leaf_count) : 0);
  }
  Result<void> prepare_page(PlantStream& plant, Transfer& transfer, PageData& data) const override;
  void build_page(PlantStream& plant, Transfer& transfer) const override;

  [[nodiscard]] std::uint64_t mesh_bytes(gpu::MeshKind kind, const WoodShape& shape) const override {
    return gpu::max_mesh_bytes(kind, shape.vertex_count, shape.triangle_count, mesh_leaves_);
  }
  [[nodiscard]] std::uint64_t mesh_scratch_bytes(std::uint32_t triangle_count) const override {
    return gpu::mesh_scratch_bytes(triangle_count);
  }
  Result<gpu::MeshBlock> build_mesh(const PlantStream& plant, gpu::MeshKind kind, const WoodSpan& mesh) const override {
    return gpu::build_mesh(kind, mesh, {{plant.looks, plant.light}, plant.leaves.box, mesh_leaves_}, plant.hooks.allocator);
  }
  [[nodiscard]] MeshLayout mesh_layout(const gpu::MeshBlock& block) const override {
    static_assert(offsetof(gpu::WoodVertex, position) == 0);
    return {0, block.vertices_at, sizeof(gpu::WoodVertex)};
  }

 private:
  bool mesh_leaves_;
};

Result<void> ClusterForm::prepare_page(PlantStream& plant, Transfer& transfer, PageData& data) const {
  const coppice_allocator& allocator = plant.hooks.allocator;
  COPPICE_CHECK(allocate_into(data.clusters, allocator, gpu::kPageBytes));
  COPPICE_CHECK(allocate_into(transfer.cluster_scratch, allocator, 1));
  if (transfer.chunk->id.index > 0) return {};
  return allocate_into(plant.ready_cuts.bytes, allocator, gpu::ready_cut_bytes(plant.file.plant.leaf_count));
}

void ClusterForm::build_page(PlantStream& plant, Transfer& transfer) const {
  const std::uint32_t page = transfer.chunk->id.index;
  PageData& data = plant.pages[page];
  const std::span<const PageNode> nodes = data.nodes.span();
  gpu::ClusterScratch& scratch = transfer.cluster_scratch[0];
  if (page == 0) {
    // Measured once, while the plant is opened, because other jobs read it afterwards.
    if (plant.leaves.light == nullptr) {
      plant.light = gpu::measure_crown({plant.leaves.root, nodes, plant.looks.cards(), plant.leaves.box});
      plant.leaves.light = &plant.light;
    }
    gpu::build_ready_cuts(plant.leaves, nodes, scratch, plant.ready_cuts);
  }
  gpu::build_page(plant.leaves, page, nodes, scratch, data.clusters.span());
}

}  // namespace

const ChunkForm& cluster_form(bool mesh_leaves) {
  static constexpr ClusterForm kWithLeaves(true), kWithout(false);
  return mesh_leaves ? kWithLeaves : kWithout;
}

}  // namespace coppice
