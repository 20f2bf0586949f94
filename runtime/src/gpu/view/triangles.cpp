#include "triangles.h"

#include <algorithm>

#include "check.h"
#include "convert.h"
#include "coppice_lod.h"
#include "cut_triangles_comp.h"
#include "descriptor_sets.h"

namespace coppice::gpu {
namespace {

std::uint32_t shown_leaf_count(const StoredPlant& plant, std::uint32_t leaf_count) {
  if (leaf_count > kReadyLeaves) return leaf_count;
  const std::uint32_t rung = std::min(lod::coppice_ladder_rung(leaf_count), kReadyCuts - 1);
  return std::min(lod::coppice_ladder_leaf_count(rung), plant.record.leaf_count);
}

/// use(mesh, bytes of a vertex) for each mesh of `of`.
template <class Use>
void for_each_mesh(const StoredPlant& plant, const CutTriangles& of, const Use& use) {
  for (std::uint32_t i = 0; of.leaf_meshes && i < plant.leaf_mesh_count; ++i) use(plant.meshes[kMaxWoodLods + i], sizeof(LeafMeshVertex));
  if (of.wood_lod) use(plant.meshes[*of.wood_lod], sizeof(WoodVertex));
}

}  // namespace

std::uint32_t triangle_count(const StoredPlant& plant, const CutTriangles& of) {
  std::uint32_t count = of.leaf_count == 0 ? 0 : 2 * shown_leaf_count(plant, of.leaf_count);
  for_each_mesh(plant, of, [&](const StoredMesh& mesh, std::size_t) { count += mesh.index_count / 3; });
  return count;
}

Result<void> TriangleWriter::create() {
  const VkPushConstantRange push{.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT, .size = sizeof(TrianglePush)};
  COPPICE_CHECK(move_into(layout_, create_pipeline_layout(device_, {}, push)));
  pipeline_ = &pipelines_.add({.name = "cut_triangles.comp", .layout = layout_, .first = cut_triangles_comp_spirv});
  return {};
}

TriangleWriter::~TriangleWriter() {
  device_.vk.vkDestroyPipelineLayout(device_.device, layout_, nullptr);
}

void TriangleWriter::record(VkCommandBuffer cmd, const StoredPlant& plant, const CutTriangles& of, std::uint64_t positions) const {
  device_.vk.vkCmdBindPipeline(cmd, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_->handle());
  // A mesh may have more groups than one dispatch takes.
  const auto dispatch = [&](const TrianglePush& push, std::uint32_t groups) {
    device_.vk.vkCmdPushConstants(cmd, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, &push);
    device_.vk.vkCmdDispatch(cmd, groups, 1, 1);
  };
  const auto groups_of = [](std::uint32_t count, std::uint32_t size) { return (count + size - 1) / size; };
  if (of.leaf_count > 0) {
    const bool paged = of.leaf_count > kReadyLeaves;
    const std::uint32_t list = paged ? kPageList : std::min(lod::coppice_ladder_rung(of.leaf_count), kReadyCuts - 1);
    const std::uint32_t clusters = paged ? groups_of(of.leaf_count - 1, kPageSplits) * kBlockClusters : 1;
    static_assert(kReadyLeaves <= kClusterLeaves, "a ready cut is one cluster");
    const std::uint64_t lists = plant.record.lists.x | std::uint64_t{plant.record.lists.y} << 32;
    dispatch({.positions = gpu_address(positions),
              .lists = gpu_address(lists + list * sizeof(ClusterList)),
              .count = of.leaf_count,
              .paged = paged ? 1u : 0u},
             clusters);
    positions += 2 * std::uint64_t{shown_leaf_count(plant, of.leaf_count)} * 3 * sizeof(vec3);
  }
  for_each_mesh(plant, of, [&](const StoredMesh& mesh, std::size_t vertex_bytes) {
    const std::uint32_t most = device_.max_group_count * kClusterLeaves / 3 * 3;
    for (std::uint32_t first = 0; first < mesh.index_count; first += most) {
      const std::uint32_t count = std::min(mesh.index_count - first, most);
      dispatch({.positions = gpu_address(positions),
                .indices = gpu_address(mesh.buffer.address + std::uint64_t{first} * sizeof(std::uint32_t)),
                .vertices = mesh.vertices,
                .count = count,
                .vertex_words = static_cast<std::uint32_t>(vertex_bytes / sizeof(std::uint32_t))},
               groups_of(count, kClusterLeaves));
      positions += std::uint64_t{count} * sizeof(vec3);
    }
  });
}

}  // namespace coppice::gpu
