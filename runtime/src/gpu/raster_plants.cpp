#include "raster_plants.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "check.h"
#include "convert.h"
#include "coppice_lod.h"

namespace coppice::gpu {
namespace {

constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
constexpr VkBufferUsageFlags kAddressed = kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

/// Leaves that are sorted into lists in one frame, about 5 ms of a core; a list that has more is built all the same.
constexpr std::uint64_t kLeavesPerFrame = 16384;

template <class T>
void append(std::vector<std::uint8_t>& bytes, const std::vector<T>& values) {
  const std::size_t at = bytes.size();
  bytes.resize(at + values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(bytes.data() + at, values.data(), values.size() * sizeof(T));
}

template <class T>
std::vector<std::uint8_t> bytes_of(const std::vector<T>& values) {
  std::vector<std::uint8_t> bytes;
  append(bytes, values);
  return bytes;
}

/// A list takes no more than this; most leaves are one splat of kMaxGrains.
std::uint64_t most_list_bytes(std::uint64_t leaf_count) {
  constexpr std::uint64_t kLeastClusterLeaves = 16;
  return leaf_count * (sizeof(RasterLeaf) + kMaxGrains * sizeof(RasterSplat)) +
         (leaf_count / kLeastClusterLeaves + 16) * sizeof(RasterCluster);
}

/// Takes a list's memory and the staging for it out of the room; false: it does not fit.
bool take_room(RasterRoom& room, std::uint64_t bytes) {
  const bool in_ring = bytes <= room.ring_bytes;
  const std::uint64_t taken = in_ring ? bytes : 2 * bytes;
  if (taken > room.device_bytes) return false;
  room.device_bytes -= taken;
  if (in_ring) room.ring_bytes -= bytes;
  return true;
}

/// Leaves of a rung: the ladder's, but for the last one, which is the whole plant.
std::uint32_t rung_leaf_count(std::uint32_t rung, std::uint32_t leaf_count) {
  return std::min(lod::coppice_ladder_leaf_count(rung), leaf_count);
}

}  // namespace

Result<void> RasterPlants::create(Device& device, Garbage& garbage, std::uint32_t max_plants) {
  device_ = &device;
  garbage_ = &garbage;
  plants_.resize(max_plants);
  static_assert(kRasterLevels > kOneClusterLevel);
  COPPICE_ASSERT(lod::coppice_ladder_leaf_count(kOneClusterLevel) == kClusterLeaves);
  COPPICE_TRY(lists, create_buffer(device, std::uint64_t{max_plants} * kRasterLists * sizeof(RasterList), kAddressed, MemoryKind::device));
  lists_ = lists;
  COPPICE_TRY(plants, create_buffer(device, std::uint64_t{max_plants} * sizeof(RasterPlant), kStorage, MemoryKind::device));
  plants_buffer_ = plants;
  // Every record is written once, so that none is read as it was allocated.
  for (PlantLists& plant : plants_) plant.changed = true;
  return {};
}

void RasterPlants::destroy() {
  if (device_ == nullptr) return;
  for (PlantLists& plant : plants_) {
    for (Batch& batch : plant.batches) destroy_buffer(*device_, batch.buffer);
    for (Buffer& buffer : plant.meshes)
      if (buffer.buffer != VK_NULL_HANDLE) destroy_buffer(*device_, buffer);
    if (plant.looks_buffer.buffer != VK_NULL_HANDLE) destroy_buffer(*device_, plant.looks_buffer);
  }
  plants_.clear();
  for (Buffer* buffer : {&lists_, &plants_buffer_})
    if (buffer->buffer != VK_NULL_HANDLE) destroy_buffer(*device_, *buffer);
}

Result<void> RasterPlants::add_plant(std::uint32_t index, const PlantFile& file) {
  PlantLists plant;
  plant.looks = plain_looks(file);
  COPPICE_TRY(looks, create_buffer(*device_, plant.looks.looks.size() * sizeof(RasterCard), kAddressed, MemoryKind::device));
  plant.used = plant.changed = plant.looks_changed = true;
  plant.leaf_count = file.plant.leaf_count;
  plant.box = leaf_box(gpu_plant(file.plant));
  plant.root = root_node(file.plant);
  if (file.plant.leaf_count > 1) plant.root.split = 0;
  plant.pages.reserve(file.plant.page_count);
  plant.looks_buffer = looks;
  plant.pending.resize(kMeshLists);
  plant.waiting.resize(kMeshLists);
  plant.lit = file.plant.page_count == 0;
  plant.meshes.resize(kMeshLists);
  plant.leaf_mesh_count = file.plant.leaf_mesh_count;
  plant.headers.resize(kRasterLists);
  plant.record.cards = gpu_address(looks.address);
  plants_[index] = std::move(plant);
  return {};
}

void RasterPlants::remove_plant(std::uint32_t index, std::uint64_t last_frame) {
  PlantLists& plant = plants_[index];
  if (!plant.used) return;
  drop_rungs(plant, 0, last_frame);
  for (const Buffer& buffer : plant.meshes)
    if (buffer.buffer != VK_NULL_HANDLE) retire(buffer, last_frame);
  retire(plant.looks_buffer, last_frame);
  plant = {};
  plant.changed = true;
}

void RasterPlants::add_page(std::uint32_t index, std::uint32_t page, std::span<const PageNode> nodes) {
  PlantLists& plant = plants_[index];
  COPPICE_ASSERT(plant.used && plant.pages.size() >= page);
  plant.pages.resize(page);
  plant.pages.push_back(nodes);
}

void RasterPlants::hide_page(std::uint32_t index, std::uint32_t page) {
  PlantLists& plant = plants_[index];
  if (page < plant.pages.size()) plant.pages.resize(page);
}

void RasterPlants::drop_page(std::uint32_t index, std::uint32_t page, std::uint64_t last_frame) {
  PlantLists& plant = plants_[index];
  if (!plant.used) return;
  hide_page(index, page);
  drop_rungs(plant, page * kPageSplits + 1, last_frame);
}

std::uint64_t RasterPlants::wood_bytes(const WoodMesh& mesh) {
  return 2 * most_list_bytes(mesh.indices.size() / 3);
}

bool RasterPlants::is_ready(const PlantLists& plant, std::uint32_t list, const WoodMesh& mesh) {
  const auto is_known = [&](const coppice::WoodVertex& vertex) { return has_texels(plant.looks, vertex.material); };
  return plant.lit && (list < kMaxWoodLods || std::ranges::all_of(mesh.vertices, is_known));
}

void RasterPlants::build_mesh_list(PlantLists& plant, std::uint32_t list, const WoodMesh& mesh) {
  if (list < kMaxWoodLods)
    plant.pending[list] = build_wood_list(mesh, {static_cast<std::uint32_t>(plant.looks.cards.size()), plant.light});
  else
    plant.pending[list] = build_leaf_mesh_list(mesh, {plant.looks, plant.box, plant.light});
}

void RasterPlants::add_mesh(PlantLists& plant, std::uint32_t list, const WoodMesh& mesh) {
  if (is_ready(plant, list, mesh))
    build_mesh_list(plant, list, mesh);
  else
    plant.waiting[list] = mesh;
}

void RasterPlants::build_waiting(PlantLists& plant) {
  for (std::uint32_t list = 0; list < kMeshLists; ++list) {
    WoodMesh& mesh = plant.waiting[list];
    if (mesh.indices.empty() || !is_ready(plant, list, mesh)) continue;
    build_mesh_list(plant, list, mesh);
    mesh = {};
  }
}

void RasterPlants::add_wood(std::uint32_t index, std::uint32_t lod, const WoodMesh& mesh) {
  add_mesh(plants_[index], lod, mesh);
}

void RasterPlants::add_leaf_mesh(std::uint32_t index, std::uint32_t chunk, const WoodMesh& mesh) {
  add_mesh(plants_[index], kMaxWoodLods + chunk, mesh);
}

void RasterPlants::set_light(std::uint32_t index, CrownLight light) {
  PlantLists& plant = plants_[index];
  plant.light = std::move(light);
  plant.lit = true;
  build_waiting(plant);
}

void RasterPlants::drop_wood(std::uint32_t index, std::uint32_t lod, std::uint64_t last_frame) {
  drop_mesh_list(index, lod, last_frame);
}

void RasterPlants::drop_leaf_mesh(std::uint32_t index, std::uint32_t chunk, std::uint64_t last_frame) {
  drop_mesh_list(index, kMaxWoodLods + chunk, last_frame);
}

void RasterPlants::drop_mesh_list(std::uint32_t index, std::uint32_t list, std::uint64_t last_frame) {
  PlantLists& plant = plants_[index];
  if (!plant.used) return;
  plant.pending[list] = {};
  plant.waiting[list] = {};
  if (plant.meshes[list].buffer == VK_NULL_HANDLE) return;
  retire(plant.meshes[list], last_frame);
  plant.meshes[list] = {};
  plant.changed = true;
}

void RasterPlants::add_texture(std::uint32_t index, std::uint32_t texture, std::span<const std::uint8_t> chunk, std::uint64_t last_frame) {
  PlantLists& plant = plants_[index];
  plant.looks_changed = true;
  if (take_texture(plant.looks, texture, chunk)) drop_rungs(plant, 0, last_frame);  // splats hold their colours
  build_waiting(plant);
}

void RasterPlants::drop_rungs(PlantLists& plant, std::uint32_t leaf_count, std::uint64_t last_frame) {
  while (!plant.batches.empty() && plant.batches.back().finest_leaf_count > leaf_count) {
    plant.record.level_count = plant.batches.back().first;
    retire(plant.batches.back().buffer, last_frame);
    plant.batches.pop_back();
    plant.changed = true;
  }
}

void RasterPlants::add_copy(VkBuffer to, std::uint64_t offset, std::vector<std::uint8_t> bytes) {
  std::erase_if(copies_, [&](const RasterCopy& copy) { return copy.to == to && copy.offset == offset; });
  copies_.push_back({to, offset, std::move(bytes)});
}

void RasterPlants::retire(const Buffer& buffer, std::uint64_t last_frame) {
  std::erase_if(copies_, [&](const RasterCopy& copy) { return copy.to == buffer.buffer; });
  garbage_->retire(last_frame, buffer);
}

/// One buffer for some lists: for each its clusters, its leaves, its splats.
Result<Buffer> RasterPlants::upload(std::span<BuiltList> built, std::span<RasterList> headers) {
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint64_t> offsets;
  for (const BuiltList& list : built) {
    offsets.push_back(bytes.size());
    append(bytes, list.clusters);
    offsets.push_back(bytes.size());
    append(bytes, list.leaves);
    offsets.push_back(bytes.size());
    append(bytes, list.splats);
  }
  COPPICE_TRY(buffer, create_buffer(*device_, bytes.size(), kAddressed, MemoryKind::device));
  for (std::size_t i = 0; i < built.size(); ++i) {
    headers[i] = built[i].header;
    headers[i].clusters = gpu_address(buffer.address + offsets[3 * i]);
    headers[i].leaves = gpu_address(buffer.address + offsets[3 * i + 1]);
    headers[i].splats = gpu_address(buffer.address + offsets[3 * i + 2]);
  }
  add_copy(buffer.buffer, 0, std::move(bytes));
  return buffer;
}

void RasterPlants::build_rungs(PlantLists& plant, std::uint32_t leaf_count, std::uint64_t& allowance, RasterRoom& room) {
  const LeafSource source{plant.root, plant.pages, plant.looks.looks, plant.box, plant.light, plant.leaf_count};
  const auto last_page_splits = plant.pages.empty() ? 0 : static_cast<std::uint32_t>(plant.pages.back().size() / 2);
  const std::uint32_t full_pages = static_cast<std::uint32_t>(std::max<std::size_t>(plant.pages.size(), 1)) - 1;
  const std::uint32_t present = full_pages * kPageSplits + last_page_splits + 1;
  std::vector<BuiltList> built;
  const std::uint32_t first = plant.record.level_count;
  for (std::uint32_t rung = first; rung < kRasterLevels && allowance > 0; ++rung) {
    const std::uint32_t wanted = rung_leaf_count(rung, plant.leaf_count);
    if (wanted > std::min(leaf_count, present)) break;
    if (rung > 0 && rung_leaf_count(rung - 1, plant.leaf_count) == plant.leaf_count) break;
    const std::uint64_t most_bytes = most_list_bytes(wanted);
    if (!take_room(room, most_bytes)) {
      lacking_bytes_ = std::max(lacking_bytes_, 2 * most_bytes);
      break;
    }
    built.push_back(build_leaf_list(source, wanted));
    allowance -= std::min<std::uint64_t>(allowance, wanted);
  }
  if (built.empty()) return;
  const auto count = static_cast<std::uint32_t>(built.size());
  auto buffer = upload(built, std::span(plant.headers).subspan(first, count));
  if (!buffer) return;
  plant.batches.push_back({*buffer, first, count, built.back().header.leaf_count});
  plant.record.level_count = first + count;
  plant.changed = true;
}

void RasterPlants::upload_mesh_lists(PlantLists& plant, RasterRoom& room) {
  for (std::uint32_t list = 0; list < kMeshLists; ++list) {
    BuiltList& pending = plant.pending[list];
    if (pending.leaves.empty()) continue;
    // Wood has had its room kept since it was uploaded; leaf meshes wait for theirs.
    const std::uint64_t bytes = most_list_bytes(pending.leaves.size());
    if (list >= kMaxWoodLods && !take_room(room, bytes)) {
      lacking_bytes_ = std::max(lacking_bytes_, 2 * bytes);
      continue;
    }
    auto buffer = upload(std::span(&pending, 1), std::span(plant.headers).subspan(kRasterLevels + list, 1));
    if (!buffer) continue;
    plant.meshes[list] = *buffer;
    plant.changed = true;
    pending = {};
  }
  const auto is_there = [&](std::uint32_t list) { return plant.meshes[list].buffer != VK_NULL_HANDLE; };
  plant.record.wood_mask = plant.record.mesh_clusters = 0;
  for (std::uint32_t lod = 0; lod < kMaxWoodLods; ++lod)
    if (is_there(lod)) plant.record.wood_mask |= 1u << lod;
  plant.record.mesh_count = plant.leaf_mesh_count;
  for (std::uint32_t chunk = 0; chunk < plant.leaf_mesh_count; ++chunk) {
    plant.record.mesh_clusters += plant.headers[kRasterMeshes + chunk].cluster_count;
    if (!is_there(kMaxWoodLods + chunk)) plant.record.mesh_count = 0;
  }
}

std::uint64_t RasterPlants::wanted_bytes() const {
  return std::max(lacking_bytes_, most_list_bytes(kLeavesPerFrame));
}

void RasterPlants::update(std::span<const std::uint32_t> leaf_counts, RasterRoom room) {
  std::uint64_t allowance = kLeavesPerFrame;
  lacking_bytes_ = 0;
  for (std::size_t i = 0; i < plants_.size(); ++i) {
    PlantLists& plant = plants_[i];
    if (plant.used) {
      build_rungs(plant, leaf_counts[i], allowance, room);
      upload_mesh_lists(plant, room);
    }
    if (plant.looks_changed) add_copy(plant.looks_buffer.buffer, 0, bytes_of(plant.looks.looks));
    plant.looks_changed = false;
    if (!plant.changed) continue;
    add_copy(plants_buffer_.buffer, i * sizeof(RasterPlant), bytes_of(std::vector{plant.record}));
    if (plant.used) add_copy(lists_.buffer, i * kRasterLists * sizeof(RasterList), bytes_of(plant.headers));
    plant.changed = false;
  }
}

std::size_t RasterPlants::bytes() const {
  std::size_t sum = 0;
  for (const PlantLists& plant : plants_) {
    sum += plant.pages.capacity() * sizeof(std::span<const PageNode>) + plant.light.cells.capacity() * sizeof(CrownSample);
    for (const Texels& texels : plant.looks.small) sum += texels.rgba.capacity();
    for (const WoodMesh& mesh : plant.waiting)
      sum += mesh.vertices.capacity() * sizeof(coppice::WoodVertex) + mesh.indices.capacity() * sizeof(std::uint32_t);
    for (const BuiltList& list : plant.pending)
      sum += list.clusters.capacity() * sizeof(RasterCluster) + list.leaves.capacity() * (sizeof(RasterLeaf) + sizeof(RasterSplat));
  }
  return sum;
}

}  // namespace coppice::gpu
