#include "draw_lists.h"

#include <algorithm>

#include "check.h"

namespace coppice::gpu {
namespace {

/// Number of clusters that a cut may be drawn from.
std::uint64_t cluster_count_of(std::uint32_t leaf_count) {
  return (std::uint64_t{leaf_count} - 1 + kPageSplits - 1) / kPageSplits * kBlockClusters;
}

/// The largest limit for each element at which their sum is at most `share`. Elements that request less leave the rest to the others.
std::uint64_t fair_share(std::span<std::uint64_t> needed, std::uint64_t share) {
  std::ranges::sort(needed);
  for (std::size_t i = 0; i < needed.size(); ++i) {
    const std::uint64_t each = share / (needed.size() - i);
    if (needed[i] > each) return each;
    share -= needed[i];
  }
  return ~std::uint64_t{0};
}

bool can_draw(const StoredPlant& plant, const DrawPipelines& pipelines) {
  if (is_depth_alone(pipelines.attachments)) return true;
  const auto drawable = [&](const SurfaceTextures& textures) {
    return pipelines.drawing(mesh_kind(kMaxWoodLods, textures.color != kNoTexture, false), DrawKind::mesh_textured) != VK_NULL_HANDLE;
  };
  return std::ranges::all_of(std::span(plant.meshes).subspan(kMaxWoodLods, plant.leaf_mesh_count),
                             [&](const StoredMesh& mesh) { return std::ranges::all_of(mesh.textures.span(), drawable); });
}

const MaterialOverride kNoOverride{.leaf_tint = vec3(1.0f),
                                   .leaf_roughness = -1.0f,
                                   .wood_tint = vec3(1.0f),
                                   .wood_roughness = -1.0f,
                                   .translucency = -1.0f,
                                   .parameters = {0, 0, 0, 0}};

}  // namespace

Result<void> DrawLists::reserve(std::uint32_t plant_count) {
  if (plant_count <= records_.size()) return {};
  COPPICE_TRY(records, enlarged_copy(records_, allocator_, plant_count));
  COPPICE_TRY(mesh_commands, enlarged_copy(mesh_commands_, allocator_, std::size_t{plant_count} * kMeshCommands));
  COPPICE_CHECK(allocate_into(needed_, allocator_, plant_count));
  records_ = std::move(records);
  mesh_commands_ = std::move(mesh_commands);
  return {};
}

void DrawLists::fill_meshes(std::uint32_t index, const DrawListInput& input) {
  const StoredPlant& plant = *input.store.plant(index);
  const LodPlant& drawn = input.plants[index];
  Plant& record = records_[index];
  for (std::uint32_t i = 0; i < kMeshCommands; ++i)
    mesh_commands_[index * kMeshCommands + i] = {.index_count = plant.meshes[i].index_count};
  for (std::uint32_t lod = 0; lod < record.wood_lod_count; ++lod) {
    const StoredMesh& wood = plant.meshes[lod];
    record.wood_index_counts[lod] = wood.index_count;
    if (wood.index_count > 0) record.wood_resident_mask |= drawn.resident_wood_mask & 1u << lod;
    if (input.raster && wood.cluster_count > 0) record.wood_list_mask |= 1u << lod;
  }
  const auto drawable = [&](const DrawPipelines& pipelines) { return can_draw(plant, pipelines); };
  if (!drawn.leaf_meshes_resident || !std::ranges::all_of(input.pipelines, drawable)) return;
  record.leaf_mesh_count = record.mesh_list_count = plant.leaf_mesh_count;
  for (std::uint32_t i = 0; i < plant.leaf_mesh_count; ++i) {
    const StoredMesh& leaves = plant.meshes[kMaxWoodLods + i];
    COPPICE_ASSERT(leaves.index_count > 0);
    record.leaf_mesh_triangles += leaves.index_count / 3;
    record.mesh_cluster_count += leaves.cluster_count;
    if (!input.raster || leaves.cluster_count == 0) record.mesh_list_count = 0;
  }
}

void DrawLists::fill_record(std::uint32_t index, const DrawListInput& input) {
  const StoredPlant* plant = input.store.plant(index);
  Plant& record = records_[index];
  record = plant != nullptr ? plant->record : Plant{};
  if (plant == nullptr) return;
  record.material_override = input.plants[index].material_override.value_or(kNoOverride);
  has_overrides_ = has_overrides_ || input.plants[index].material_override.has_value();
  record.instance_count = input.instances.plant_count(index);
  if (record.instance_count == 0) return;  // true also for a closing plant, some of whose chunks are gone
  record.resident_leaf_count = plant->has_cuts ? std::clamp(input.plants[index].resident_leaf_count, 1u, kMaxDrawnLeaves) : 0;
  fill_meshes(index, input);
}

std::uint64_t DrawLists::needed_commands(const Device& device, std::uint32_t plant) const {
  const Plant& record = records_[plant];
  if (record.resident_leaf_count == 0) return 0;
  return std::min<std::uint64_t>(record.instance_count * cluster_count_of(record.resident_leaf_count), device.max_draw_count);
}

std::uint64_t DrawLists::needed_parts(std::uint32_t plant) const {
  const Plant& record = records_[plant];
  return record.instance_count > 0 ? (record.wood_lod_count + record.leaf_mesh_count) * std::uint64_t{kPartCommands} : 0;
}

/// An instance always has a command for a cut of one cluster. If it finds none for its clusters, it is drawn coarser, or rasterised.
/// max_clusters: commands that a plant has for clusters. parts: it has commands for parts of meshes
void DrawLists::place(std::uint64_t max_clusters, bool parts) {
  std::uint64_t command_count = 0, list_count = 0;
  for (std::uint32_t i = 0; i < count_; ++i) {
    Plant& record = records_[i];
    const std::uint64_t count = record.instance_count;
    record.leaf_command_base = static_cast<std::uint32_t>(command_count);
    record.leaf_command_capacity = static_cast<std::uint32_t>(std::min<std::uint64_t>(record.leaf_command_capacity, max_clusters));
    command_count += count + record.leaf_command_capacity;
    record.part_base = static_cast<std::uint32_t>(command_count);
    record.part_capacity = parts ? kPartCommands : 0;
    if (parts) command_count += needed_parts(i);
    record.wood_list_base = static_cast<std::uint32_t>(list_count);
    record.leaf_mesh_list_base = static_cast<std::uint32_t>(list_count + count * record.wood_lod_count);
    list_count += count * (record.wood_lod_count + (record.leaf_mesh_count > 0 ? 1 : 0));
  }
}

DrawLists::Needed DrawLists::add_up(const Device& device) {
  Needed needed;
  for (std::uint32_t i = 0; i < count_; ++i) {
    Plant& record = records_[i];
    record.leaf_command_capacity = static_cast<std::uint32_t>(needed_commands(device, i));
    if (record.instance_count == 0) continue;
    needed_[needed.plants++] = record.leaf_command_capacity;
    needed.single_bytes += record.instance_count * sizeof(DrawCommand);
    needed.part_bytes += needed_parts(i) * sizeof(DrawCommand);
    needed.cluster_bytes += record.leaf_command_capacity * sizeof(DrawCommand);
  }
  return needed;
}

/// Replaces a smaller buffer if memory is free. True if it did
bool DrawLists::grow(Device& device, DeferredDeletion& deletion, std::uint64_t needed_bytes, Buffer& commands) {
  if (needed_bytes <= commands.size_bytes || !fits_buffer(device, needed_bytes)) return false;
  const std::uint64_t roomy = std::min(needed_bytes + needed_bytes / 4, std::max(needed_bytes, device.max_storage_bytes));
  const std::uint64_t bytes = roomy <= device.memory.ledger->free() / 2 ? roomy : needed_bytes;
  constexpr VkBufferUsageFlags kUsage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
  auto made = create_buffer(device, {kLeafCommandsName, bytes, kUsage, MemoryKind::alone});
  if (!made) {
    go_on_without(device, made.error(), "some plants are drawn coarser or by the rasteriser");
    return false;
  }
  deletion.defer(commands);
  commands = *made;
  return true;
}

// All slots have commands for single clusters. Commands for clusters and parts are limited by their share of the budget and by free memory.
bool DrawLists::fill(Device& device, DeferredDeletion& deletion, const DrawListInput& input, std::span<Buffer* const> commands) {
  count_ = input.store.count();
  has_overrides_ = false;
  for (std::uint32_t i = 0; i < count_; ++i) fill_record(i, input);
  const Needed needed = add_up(device);
  const std::uint64_t most_bytes = std::min(input.memory_budget_bytes / kCommandShare, device.max_storage_bytes - needed.single_bytes);
  const std::uint64_t needed_bytes = needed.single_bytes + std::min(needed.part_bytes + needed.cluster_bytes, most_bytes);
  bool grown = false;
  std::uint64_t bytes = needed_bytes;
  for (Buffer* of_view : commands) {
    if (grow(device, deletion, needed_bytes, *of_view)) grown = true;
    bytes = std::min(bytes, of_view->size_bytes);
  }
  std::uint64_t room = bytes - std::min(bytes, needed.single_bytes);
  const bool parts = needed.part_bytes + std::min(needed.cluster_bytes, room / 2) <= room;
  if (parts) room -= needed.part_bytes;
  place(fair_share(needed_.span().first(needed.plants), room / sizeof(DrawCommand)), parts);
  return grown;
}

}  // namespace coppice::gpu
