#include <algorithm>
#include <cstring>

#include "block_texture.h"
#include "check.h"
#include "convert.h"
#include "renderer.h"

namespace coppice::gpu {
namespace {

constexpr VkPipelineStageFlags2 kReadStages = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
                                              VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT |
                                              VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
constexpr VkAccessFlags2 kReads = VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_INDEX_READ_BIT |
                                  VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT;

VkImageMemoryBarrier2 layout_change(VkImage image, VkImageLayout from, VkImageLayout to) {
  const bool filling = to == VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  return {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
          .srcStageMask = filling ? VK_PIPELINE_STAGE_2_NONE : VK_PIPELINE_STAGE_2_COPY_BIT,
          .srcAccessMask = filling ? VK_ACCESS_2_NONE : VK_ACCESS_2_TRANSFER_WRITE_BIT,
          .dstStageMask =
              filling ? VK_PIPELINE_STAGE_2_COPY_BIT
                      : kReadStages & ~VkPipelineStageFlags2{VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT},
          .dstAccessMask = filling ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
          .oldLayout = from,
          .newLayout = to,
          .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
          .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
          .image = image,
          .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, 1}};
}

constexpr VkBufferUsageFlags kAddressed = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

template <class T>
std::span<const std::uint8_t> bytes_of(std::span<const T> values) {
  return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()};
}

}  // namespace

void Renderer::record_upload_begin(VkCommandBuffer cmd) {
  upload_cmd_ = cmd;
  drawable_ = false;
  take_larger();
}

Result<StagingSlice> Renderer::stage(std::uint64_t bytes) {
  return staging_.allocate(device_, garbage_, frame_, bytes);
}

Result<void> Renderer::stage_copy(const void* data, std::uint64_t bytes, VkBuffer to, std::uint64_t offset) {
  COPPICE_TRY(slice, stage(bytes));
  std::memcpy(slice.data, data, bytes);
  copies_.push_back({slice.buffer, to, {slice.offset, offset, bytes}});
  return {};
}

/// Overwrites a part of the plant's tables, also of what has not gone up yet: its copy in a later frame must not undo this.
Result<void> Renderer::stage_patch(PlantSlot& plant, std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  COPPICE_TRY(slice, stage(bytes.size()));
  std::memcpy(slice.data, bytes.data(), bytes.size());
  patches_.push_back({slice.buffer, plant.tables.buffer, {slice.offset, offset, bytes.size()}});
  if (!plant.pending_tables.empty()) std::memcpy(plant.pending_tables.data() + offset, bytes.data(), bytes.size());
  return {};
}

Result<void> Renderer::stage_cuts(PlantSlot& plant, ReadyCuts& cuts) {
  move_ready_cuts(plant.record.leaf_count, cuts.lists, cuts.bytes.span(), plant.tables.address + plant.layout.cuts_at);
  COPPICE_CHECK(stage_patch(plant, plant.layout.lists_at, bytes_of(std::span<const ClusterList>(cuts.lists))));
  COPPICE_CHECK(stage_patch(plant, plant.layout.cuts_at, cuts.bytes.span()));
  plant.has_cuts = true;
  want_leaves(plant);
  return {};
}

Result<void> Renderer::upload_page(const PageUpload& upload) {
  PlantSlot& plant = plants_[upload.plant];
  COPPICE_ASSERT(plant.used && plant.pages[upload.page].buffer == VK_NULL_HANDLE && upload.clusters.size() == kPageBytes);
  COPPICE_TRY(page, stage(kPageBytes));
  if (upload.page == 0) COPPICE_CHECK(stage_cuts(plant, *upload.ready_cuts));
  COPPICE_TRY(buffer, create_buffer(device_, kPageBytes, kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, MemoryKind::device));
  const uvec2 address = gpu_address(buffer.address);
  auto patched = stage_patch(plant, plant.layout.pages_at + upload.page * sizeof address, bytes_of(std::span(&address, 1)));
  if (!patched) {
    destroy_buffer(device_, buffer);
    return patched;
  }
  move_clusters(upload.clusters, kBlockClusters, buffer.address);
  std::memcpy(page.data, upload.clusters.data(), kPageBytes);
  copies_.push_back({page.buffer, buffer.buffer, {page.offset, 0, kPageBytes}});
  plant.pages[upload.page] = buffer;
  return {};
}

Result<void> Renderer::upload_mesh(const MeshUpload& upload) {
  PlantSlot& plant = plants_[upload.plant];
  MeshBuffer& mesh = plant.meshes[upload.mesh];
  MeshBlock& block = *upload.block;
  COPPICE_ASSERT(plant.used && mesh.buffer.buffer == VK_NULL_HANDLE);
  COPPICE_TRY(slice, stage(block.bytes.size()));
  COPPICE_TRY(buffer, create_buffer(device_, block.bytes.size(),
                                    kAddressed | VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::device));
  block.move(buffer.address);
  auto patched = stage_patch(plant, plant.layout.lists_at + (kWoodLists + upload.mesh) * sizeof(ClusterList),
                             bytes_of(std::span<const ClusterList>(&block.list, 1)));
  if (!patched) {
    destroy_buffer(device_, buffer);
    return patched;
  }
  std::memcpy(slice.data, block.bytes.data(), block.bytes.size());
  copies_.push_back({slice.buffer, buffer.buffer, {slice.offset, 0, block.bytes.size()}});
  mesh = {.buffer = buffer,
          .vertices = gpu_address(buffer.address + block.vertices_at),
          .index_count = block.index_count,
          .cluster_count = block.list.cluster_count};
  for (std::size_t material = 0; material < plant.material_textures.size(); ++material) {
    const SurfaceTextures& textures = plant.material_textures[material];
    if (block.materials[material] && std::ranges::find(mesh.textures, textures) == mesh.textures.end()) mesh.textures.push_back(textures);
  }
  want_mesh(upload.mesh < kMaxWoodLods ? passes_.camera.wood : passes_.camera.leaf_mesh, mesh);
  return {};
}

Result<void> Renderer::upload_texture(std::uint32_t plant_index, std::uint32_t index, std::span<const std::uint8_t> bytes) {
  PlantTexture& plant_texture = plants_[plant_index].textures[index];
  COPPICE_TRY(layout, read_texture(bytes));
  if (layout.format != COPPICE_TEXTURE_RGBA8 && !device_.block_textures)
    return Error{Status::unsupported, "a texture in blocks, without textureCompressionBC"};
  coppice_file_texture header{};
  std::memcpy(&header, bytes.data(), sizeof header);
  COPPICE_TRY(texture, create_texture(device_, header));
  auto set = create_texture_set(device_, passes_, texture.view);
  auto staged = set ? stage_texels(texture, bytes.subspan(sizeof header)) : Result<void>(set.error());
  if (!staged) {
    destroy_texture(device_, texture);
    if (set) device_.vk.vkDestroyDescriptorPool(device_.device, set->pool, nullptr);
    return staged.error();
  }
  plant_texture = {.texture = texture, .set = *set, .visible = true};
  return {};
}

Result<void> Renderer::stage_texels(const Texture& texture, std::span<const std::uint8_t> texels) {
  COPPICE_TRY(slice, stage(texels.size()));
  std::memcpy(slice.data, texels.data(), texels.size());
  texture_copies_.push_back({slice.buffer, slice.offset, texture.image, texture.width, texture.height, texture.mip_count, texture.format});
  return {};
}

Result<void> Renderer::stage_once() {
  if (once_staged_) return {};
  constexpr std::uint16_t kQuad[6] = {0, 1, 2, 0, 2, 3};
  std::array<std::uint16_t, std::size_t{kClusterLeaves} * 6> indices{};
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint16_t>(i / 6 * 4 + kQuad[i % 6]);
  COPPICE_CHECK(stage_copy(indices.data(), indices.size() * sizeof(std::uint16_t), fixed_.indices.buffer, 0));
  constexpr std::uint8_t kWhite[4] = {255, 255, 255, 255};
  COPPICE_CHECK(stage_texels(default_texture_, kWhite));
  once_staged_ = true;
  return {};
}

Result<void> Renderer::stage_plant_tables() {
  for (std::uint32_t i = 0; i < plants_.size(); ++i) {
    PlantSlot& plant = plants_[i];
    if (plant.pending_tables.empty()) continue;
    COPPICE_CHECK(stage_copy(plant.pending_tables.data(), plant.pending_tables.size(), plant.tables.buffer, 0));
    COPPICE_CHECK(stage_copy(plant.pending_words.data(), plant.pending_words.size() * sizeof(std::uint32_t), growing_.tables.buffer,
                             std::uint64_t{i} * kTableStride * sizeof(std::uint32_t)));
    plant.pending_tables = {};
    plant.pending_words = {};
  }
  return {};
}

Result<void> Renderer::stage_instances(InstanceTable& instances) {
  const std::span<const Instance> slots = instances.slots();
  COPPICE_ASSERT(slots.size() <= capacity_.slots);
  instance_slot_count_ = static_cast<std::uint32_t>(slots.size());
  instances.update_bounds();
  for (SlotRange range = instances.take_dirty(); range.count > 0; range = instances.take_dirty()) {
    auto staged =
        stage_copy(slots.data() + range.first, range.count * sizeof(Instance), growing_.instances.buffer, range.first * sizeof(Instance));
    if (staged && raster_) {
      static_assert(kDirtyBlockSlots % kBlockSlots == 0);
      const auto blocks =
          gpu_blocks(instances.blocks().bounds.subspan(range.first / kBlockSlots, (range.count + kBlockSlots - 1) / kBlockSlots));
      staged = stage_copy(blocks.data(), blocks.size() * sizeof(InstanceBlock), raster_->block_buffer(),
                          range.first / kBlockSlots * sizeof(InstanceBlock));
    }
    if (staged) continue;
    instances.mark_dirty(range);
    return staged.error();
  }
  return {};
}

namespace {

/// Draw commands of clusters take at most one part in this many of the memory budget.
constexpr std::uint64_t kCommandShare = 64;

/// Clusters that a cut may be drawn from.
std::uint64_t cluster_count_of(std::uint32_t leaf_count) {
  return (std::uint64_t{leaf_count} - 1 + kPageSplits - 1) / kPageSplits * kBlockClusters;
}

/// The most that each of these may have so that all have no more than `share`: those that want less leave theirs to the others.
std::uint64_t fair_share(std::vector<std::uint64_t> wanted, std::uint64_t share) {
  std::ranges::sort(wanted);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const std::uint64_t each = share / (wanted.size() - i);
    if (wanted[i] > each) return each;
    share -= wanted[i];
  }
  return ~std::uint64_t{0};
}

}  // namespace

void Renderer::fill_meshes(std::uint32_t index, const PlantResidency& residency) {
  const PlantSlot& plant = plants_[index];
  Plant& record = records_[index];
  for (std::uint32_t i = 0; i < kMeshCommands; ++i)
    mesh_templates_[index * kMeshCommands + i] = {.index_count = plant.meshes[i].index_count};
  for (std::uint32_t lod = 0; lod < record.wood_lod_count; ++lod) {
    const MeshBuffer& wood = plant.meshes[lod];
    record.wood_index_counts[lod] = wood.index_count;
    if (wood.index_count > 0) record.wood_resident_mask |= residency.wood_mask & 1u << lod;
    if (raster_ && wood.cluster_count > 0) record.wood_list_mask |= 1u << lod;
  }
  if (!residency.leaf_meshes || !can_draw_leaf_meshes(plant)) return;
  record.leaf_mesh_count = record.mesh_list_count = plant.leaf_mesh_count;
  for (std::uint32_t i = 0; i < plant.leaf_mesh_count; ++i) {
    const MeshBuffer& leaves = plant.meshes[kMaxWoodLods + i];
    COPPICE_ASSERT(leaves.index_count > 0);
    record.leaf_mesh_triangles += leaves.index_count / 3;
    record.mesh_cluster_count += leaves.cluster_count;
    if (!raster_ || leaves.cluster_count == 0) record.mesh_list_count = 0;
  }
}

void Renderer::fill_records(const InstanceTable& instances, std::span<const PlantResidency> residency) {
  for (std::uint32_t i = 0; i < plants_.size(); ++i) {
    const PlantSlot& plant = plants_[i];
    plant_counts_[i] = plant.used ? instances.plant_count(i) : 0;
    records_[i] = plant.record;
    if (!plant.used) continue;
    records_[i].instance_count = plant_counts_[i];
    records_[i].resident_leaf_count = plant.has_cuts ? std::clamp(residency[i].leaf_count, 1u, kMaxDrawnLeaves) : 0;
    fill_meshes(i, residency[i]);
  }
}

/// An instance has a command for a cut of one cluster in any case. What finds none for its clusters is drawn coarser, or rasterised.
/// most_clusters: commands that a plant has for clusters. parts: it has commands for parts of meshes
void Renderer::place_draws(std::uint64_t most_clusters, bool parts) {
  std::uint64_t command_count = 0, list_count = 0;
  for (std::uint32_t i = 0; i < plants_.size(); ++i) {
    Plant& record = records_[i];
    if (!plants_[i].used) continue;
    const std::uint64_t count = plant_counts_[i];
    record.leaf_command_base = static_cast<std::uint32_t>(command_count);
    record.leaf_command_capacity = static_cast<std::uint32_t>(std::min(wanted_commands(i), most_clusters));
    command_count += count + record.leaf_command_capacity;
    record.part_base = static_cast<std::uint32_t>(command_count);
    record.part_capacity = parts ? kPartCommands : 0;
    if (parts) command_count += wanted_parts(i);
    record.wood_list_base = static_cast<std::uint32_t>(list_count);
    record.leaf_mesh_list_base = static_cast<std::uint32_t>(list_count + count * record.wood_lod_count);
    list_count += count * (record.wood_lod_count + (record.leaf_mesh_count > 0 ? 1 : 0));
  }
}

std::uint64_t Renderer::wanted_commands(std::uint32_t plant) const {
  const std::uint32_t leaf_count = records_[plant].resident_leaf_count;
  return leaf_count == 0 ? 0 : std::min<std::uint64_t>(plant_counts_[plant] * cluster_count_of(leaf_count), device_.max_draw_count);
}

std::uint64_t Renderer::wanted_parts(std::uint32_t plant) const {
  return plant_counts_[plant] > 0 ? (records_[plant].wood_lod_count + records_[plant].leaf_mesh_count) * std::uint64_t{kPartCommands} : 0;
}

// There are commands for single clusters for all slots; for clusters and parts as far as the share of the budget goes and there is room.
Result<void> Renderer::reserve_draws() {
  std::vector<std::uint64_t> wanted;
  std::uint64_t single_bytes = 0, part_bytes = 0, cluster_bytes = 0;
  for (std::uint32_t i = 0; i < plants_.size(); ++i) {
    if (plant_counts_[i] == 0) continue;
    wanted.push_back(wanted_commands(i));
    single_bytes += plant_counts_[i] * sizeof(DrawCommand);
    part_bytes += wanted_parts(i) * sizeof(DrawCommand);
    cluster_bytes += wanted.back() * sizeof(DrawCommand);
  }
  const std::uint64_t most_bytes = std::min(desc_.memory_budget_bytes / kCommandShare, device_.max_storage_bytes - single_bytes);
  const std::uint64_t wanted_bytes = single_bytes + std::min(part_bytes + cluster_bytes, most_bytes);
  if (wanted_bytes > leaf_commands_.size_bytes && fits(wanted_bytes)) {
    const std::uint64_t roomy = std::min(wanted_bytes + wanted_bytes / 4, std::max(wanted_bytes, device_.max_storage_bytes));
    const std::uint64_t bytes = roomy <= device_.memory.ledger->free() / 2 ? roomy : wanted_bytes;
    auto larger = create_buffer(device_, bytes, kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, MemoryKind::alone);
    if (larger) {
      garbage_.retire(frame_, leaf_commands_);
      leaf_commands_ = *larger;
      frame_set_stale_ = true;
    } else {
      go_on_without(device_, larger.error(), "some plants are drawn coarser or by the rasteriser");
    }
  }
  const std::uint64_t room = std::min(wanted_bytes, leaf_commands_.size_bytes) - single_bytes;
  const bool parts = part_bytes + std::min(cluster_bytes, room / 2) <= room;
  place_draws(fair_share(std::move(wanted), (parts ? room - part_bytes : room) / sizeof(DrawCommand)), parts);
  // Also what a growth left behind that failed half way in an earlier frame.
  return frame_set_stale_ ? rebuild_frame_set() : Result<void>();
}

Result<void> Renderer::stage_frame(InstanceTable& instances, std::span<const PlantResidency> residency) {
  COPPICE_CHECK(stage_once());
  COPPICE_CHECK(stage_plant_tables());
  COPPICE_CHECK(stage_instances(instances));
  fill_records(instances, residency);
  return reserve_draws();
}

Result<void> Renderer::record_upload_end(InstanceTable& instances, std::span<const PlantResidency> residency) {
  COPPICE_ASSERT(upload_cmd_ != VK_NULL_HANDLE && residency.size() >= plants_.size());
  auto staged = stage_frame(instances, residency);
  if (timer_.exists()) timer_.begin(device_, upload_cmd_, frame_, completed_);
  memory_barrier(device_, upload_cmd_, kReadStages | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                 VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT);
  const auto wait_for_copies = [&] {
    memory_barrier(device_, upload_cmd_, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_COPY_BIT,
                   VK_ACCESS_2_TRANSFER_WRITE_BIT);
  };
  if (!moves_.empty()) {
    record_buffer_copies(moves_);
    wait_for_copies();
  }
  record_buffer_copies(copies_);
  update_buffer(upload_cmd_, growing_.plants, records_.data(), records_.size() * sizeof(Plant));
  if (!patches_.empty()) {
    wait_for_copies();
    record_buffer_copies(patches_);
  }
  record_texture_copies();
  memory_barrier(device_, upload_cmd_, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, kReadStages, kReads);
  if (timer_.exists()) timer_.mark(device_, upload_cmd_, Pass::upload);
  upload_cmd_ = VK_NULL_HANDLE;
  drawable_ = static_cast<bool>(staged);
  return staged;
}

void Renderer::record_buffer_copies(std::vector<Copy>& copies) {
  std::stable_sort(copies.begin(), copies.end(),
                   [](const Copy& a, const Copy& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
  std::vector<VkBufferCopy> regions;
  for (std::size_t i = 0; i < copies.size(); ++i) {
    regions.push_back(copies[i].region);
    if (i + 1 < copies.size() && copies[i + 1].from == copies[i].from && copies[i + 1].to == copies[i].to) continue;
    device_.vk.vkCmdCopyBuffer(upload_cmd_, copies[i].from, copies[i].to, static_cast<std::uint32_t>(regions.size()), regions.data());
    regions.clear();
  }
  copies.clear();
}

void Renderer::record_texture_copies() {
  for (const TextureCopy& copy : texture_copies_) {
    VkImageMemoryBarrier2 barrier = layout_change(copy.image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
    device_.vk.vkCmdPipelineBarrier2(upload_cmd_, &info);
    std::vector<VkBufferImageCopy> regions;
    std::uint64_t offset = copy.offset;
    for (std::uint32_t mip = 0; mip < copy.mip_count; ++mip) {
      const std::uint32_t width = std::max(copy.width >> mip, 1u);
      const std::uint32_t height = std::max(copy.height >> mip, 1u);
      regions.push_back(
          {.bufferOffset = offset, .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, mip, 0, 1}, .imageExtent = {width, height, 1}});
      offset += texture_level_bytes(copy.format, width, height);
    }
    device_.vk.vkCmdCopyBufferToImage(upload_cmd_, copy.from, copy.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                      static_cast<std::uint32_t>(regions.size()), regions.data());
    barrier = layout_change(copy.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    device_.vk.vkCmdPipelineBarrier2(upload_cmd_, &info);
  }
  texture_copies_.clear();
}

void Renderer::update_buffer(VkCommandBuffer cmd, const Buffer& buffer, const void* data, std::uint64_t bytes) const {
  constexpr std::uint64_t kMaxUpdateBytes = 65536;
  const auto* from = static_cast<const std::uint8_t*>(data);
  for (std::uint64_t at = 0; at < bytes; at += kMaxUpdateBytes)
    device_.vk.vkCmdUpdateBuffer(cmd, buffer.buffer, at, std::min(kMaxUpdateBytes, bytes - at), from + at);
}

}  // namespace coppice::gpu
