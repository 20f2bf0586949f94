#include "raster_plants.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "check.h"
#include "convert.h"
#include "coppice_lod.h"
#include "page_codec.h"

namespace coppice::gpu {
namespace {

constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
constexpr VkBufferUsageFlags kAddressed = kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

/// Leaves that one job sorts into lists, about 7 ms of a core; a list that has more is built all the same.
constexpr std::uint64_t kLeavesPerJob = 16384;
/// Lists of no more leaves are built by the frame's thread, so that a plant is never without; and so many leaves of them in a frame.
constexpr std::uint32_t kLeavesAtOnce = 128;
constexpr std::uint64_t kLeavesPerFrame = 4096;

template <class T>
std::vector<std::uint8_t> bytes_of(const std::vector<T>& values) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

/// A list takes no more than this; most leaves are one splat of kMaxGrains.
std::uint64_t most_list_bytes(std::uint64_t leaf_count) {
  constexpr std::uint64_t kLeastClusterLeaves = 16;
  return leaf_count * (sizeof(RasterLeaf) + kMaxGrains * sizeof(RasterSplat)) +
         (leaf_count / kLeastClusterLeaves + 16) * sizeof(RasterCluster);
}

std::uint32_t triangle_count(const WoodMesh& mesh) {
  return static_cast<std::uint32_t>(mesh.indices.size() / 3);
}

std::uint64_t mesh_bytes(const WoodMesh& mesh) {
  return mesh.vertices.size() * sizeof(coppice::WoodVertex) + mesh.indices.size() * sizeof(std::uint32_t);
}

/// That a cut is in.
std::uint32_t page_count(std::uint32_t leaf_count) {
  return (leaf_count - 1 + kPageSplits - 1) / kPageSplits;
}

/// What a list's memory and the staging for it take of the room.
std::uint64_t device_bytes(const RasterRoom& room, std::uint64_t list_bytes) {
  return list_bytes <= room.ring_bytes ? list_bytes : 2 * list_bytes;
}

/// Leaves of a rung: the ladder's, but for the last one, which is the whole plant.
std::uint32_t rung_leaf_count(std::uint32_t rung, std::uint32_t leaf_count) {
  return std::min(lod::coppice_ladder_leaf_count(rung), leaf_count);
}

/// Of the finest cut that the pages hold.
std::uint32_t present_leaf_count(std::span<const SharedNodes> pages) {
  if (pages.empty()) return 1;
  return static_cast<std::uint32_t>((pages.size() - 1) * kPageSplits + pages.back().nodes.size() / 2 + 1);
}

}  // namespace

Result<void> RasterPlants::create(Device& device, Garbage& garbage, std::uint32_t max_plants, const coppice_jobs& jobs) {
  device_ = &device;
  garbage_ = &garbage;
  jobs_ = jobs;
  static_assert(kRasterLevels > kOneClusterLevel);
  COPPICE_ASSERT(lod::coppice_ladder_leaf_count(kOneClusterLevel) == kClusterLeaves);
  COPPICE_TRY(lists, create_buffer(device, std::uint64_t{max_plants} * kRasterLists * sizeof(RasterList), kAddressed, MemoryKind::device));
  lists_ = lists;
  COPPICE_TRY(plants, create_buffer(device, std::uint64_t{max_plants} * sizeof(RasterPlant), kStorage, MemoryKind::device));
  plants_buffer_ = plants;
  return {};
}

void RasterPlants::destroy() {
  if (device_ == nullptr) return;
  for (PlantLists& plant : plants_) {
    for (Batch& batch : plant.batches) destroy_buffer(*device_, batch.buffer);
    for (MeshList& mesh : plant.meshes)
      if (mesh.buffer.buffer != VK_NULL_HANDLE) destroy_buffer(*device_, mesh.buffer);
    if (plant.looks_buffer.buffer != VK_NULL_HANDLE) destroy_buffer(*device_, plant.looks_buffer);
  }
  plants_.clear();
  for (Buffer* buffer : {&lists_, &plants_buffer_})
    if (buffer->buffer != VK_NULL_HANDLE) destroy_buffer(*device_, *buffer);
}

Result<void> RasterPlants::add_plant(std::uint32_t index, const PlantFile& file) {
  if (index >= plants_.size()) plants_.resize(index + 1);
  PlantLists plant;
  const auto looks = std::make_shared<PlantLooks>(plain_looks(file));
  const std::uint64_t looks_bytes = looks->looks.size() * sizeof(RasterCard),
                      colors_bytes = looks->wood_colors.size() * sizeof(std::uint32_t);
  COPPICE_TRY(buffer, create_buffer(*device_, looks_bytes + colors_bytes, kAddressed, MemoryKind::device));
  plant.used = plant.changed = plant.looks_changed = true;
  plant.generation = ++last_generation_;
  plant.source = {looks, std::make_shared<CrownLight>(), leaf_box(gpu_plant(file.plant)), file.plant.leaf_count};
  plant.lit = file.plant.page_count == 0;
  plant.texture_taken.resize(file.plant.texture_count);
  plant.root = root_node(file.plant);
  plant.pages.reserve(file.plant.page_count);
  plant.looks_buffer = buffer;
  plant.meshes.resize(kMeshLists);
  plant.leaf_mesh_count = file.plant.leaf_mesh_count;
  plant.headers.resize(kRasterLists);
  plant.record.cards = gpu_address(buffer.address);
  plant.record.wood_colors = gpu_address(buffer.address + looks_bytes);
  plants_[index] = std::move(plant);
  return {};
}

void RasterPlants::remove_plant(std::uint32_t index, std::uint64_t last_frame) {
  PlantLists& plant = plants_[index];
  if (!plant.used) return;
  drop_rungs(plant, 0, last_frame);
  for (const MeshList& mesh : plant.meshes)
    if (mesh.buffer.buffer != VK_NULL_HANDLE) retire(mesh.buffer, last_frame);
  retire(plant.looks_buffer, last_frame);
  plant = {};
  plant.changed = true;
}

void RasterPlants::add_page(std::uint32_t index, std::uint32_t page, SharedNodes nodes) {
  PlantLists& plant = plants_[index];
  COPPICE_ASSERT(plant.used && plant.pages.size() >= page);
  plant.pages.resize(page);
  plant.pages.push_back(std::move(nodes));
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
  return mesh_bytes(mesh) + most_list_bytes(triangle_count(mesh));
}

void RasterPlants::add_wood(std::uint32_t index, std::uint32_t lod, const WoodMesh& mesh) {
  PlantLists& plant = plants_[index];
  MeshList& list = plant.meshes[lod];
  list.waiting = mesh;
  // What a texture covers is built into the list; the colour of what it covers is looked up, so that nothing else waits.
  for (const coppice::WoodVertex& vertex : mesh.vertices)
    if (is_masked(plant.source.looks->materials[vertex.material])) list.materials.insert(vertex.material);
}

void RasterPlants::add_leaf_mesh(std::uint32_t index, std::uint32_t chunk, const WoodMesh& mesh) {
  MeshList& list = plants_[index].meshes[kMaxWoodLods + chunk];
  list.waiting = mesh;
  for (const coppice::WoodVertex& vertex : mesh.vertices) list.materials.insert(vertex.material);
}

void RasterPlants::set_light(std::uint32_t index, CrownLight light) {
  PlantLists& plant = plants_[index];
  plant.source.light = std::make_shared<CrownLight>(std::move(light));
  plant.lit = true;
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
  const MeshList dropped = std::exchange(plant.meshes[list], {});
  if (dropped.buffer.buffer == VK_NULL_HANDLE) return;
  retire(dropped.buffer, last_frame);
  plant.changed = true;
}

void RasterPlants::add_texture(std::uint32_t index, std::uint32_t texture, std::span<const std::uint8_t> chunk) {
  PlantLists& plant = plants_[index];
  if (plant.texture_taken[texture]) return;
  auto looks = std::make_shared<PlantLooks>(*plant.source.looks);
  take_texture(*looks, texture, chunk);
  plant.source.looks = std::move(looks);
  plant.texture_taken[texture] = plant.looks_changed = true;
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

ListBuild RasterPlants::new_build(const PlantLists& plant, std::uint32_t index, std::uint32_t first) {
  ListBuild build;
  build.plant = index;
  build.generation = plant.generation;
  build.first = first;
  build.source = plant.source;
  return build;
}

/// Cuts that are missing.
void RasterPlants::gather_cuts(std::uint32_t index, std::uint32_t leaf_count, Allowance& allowance, std::vector<ListBuild>& builds) {
  PlantLists& plant = plants_[index];
  const std::uint32_t all = plant.source.leaf_count, most = std::min(leaf_count, present_leaf_count(plant.pages));
  const std::uint32_t first = plant.record.level_count;
  std::vector<std::uint32_t> wanted_counts;
  std::uint64_t kept_bytes = 0;
  for (std::uint32_t rung = first; rung < kRasterLevels && (allowance.leaves > 0 || rung == first); ++rung) {
    const std::uint32_t wanted = rung_leaf_count(rung, all);
    if (wanted > std::min(most, allowance.most_leaves)) break;
    if (rung > 0 && rung_leaf_count(rung - 1, all) == all) break;
    if (!take_room(allowance.room, most_list_bytes(wanted))) break;
    kept_bytes += most_list_bytes(wanted);
    wanted_counts.push_back(wanted);
    allowance.leaves -= std::min<std::uint64_t>(allowance.leaves, wanted);
  }
  if (wanted_counts.empty()) return;
  ListBuild& build = builds.emplace_back(new_build(plant, index, first));
  build.leaf_counts = std::move(wanted_counts);
  build.kept_bytes = kept_bytes;
  build.root = plant.root;
  build.pages.assign(plant.pages.begin(), plant.pages.begin() + static_cast<std::ptrdiff_t>(page_count(build.leaf_counts.back())));
  plant.cuts_building = true;
}

void RasterPlants::gather_meshes(std::uint32_t index, Allowance& allowance, std::vector<ListBuild>& builds) {
  PlantLists& plant = plants_[index];
  for (std::uint32_t list = 0; list < kMeshLists && allowance.leaves > 0; ++list) {
    MeshList& mesh = plant.meshes[list];
    const std::uint32_t triangles = triangle_count(mesh.waiting);
    if (triangles == 0 || triangles > allowance.most_leaves) continue;
    const bool is_wood = list < kMaxWoodLods;
    if (!std::ranges::all_of(mesh.materials, [&](std::uint32_t material) { return has_texels(*plant.source.looks, material); })) continue;
    // Wood has had its room kept since it was uploaded; leaf meshes wait for theirs.
    if (!is_wood && !take_room(allowance.room, most_list_bytes(triangles))) continue;
    ListBuild& build = builds.emplace_back(new_build(plant, index, kRasterLevels + list));
    build.kept_bytes = wood_bytes(mesh.waiting);
    build.mesh = std::exchange(mesh.waiting, {});
    mesh.building = true;
    allowance.leaves -= std::min<std::uint64_t>(allowance.leaves, triangles);
  }
}

std::vector<ListBuild> RasterPlants::gather(std::span<const std::uint32_t> leaf_counts, Allowance allowance) {
  std::vector<ListBuild> builds;
  for (std::uint32_t i = 0; i < plants_.size(); ++i) {
    if (!plants_[i].used || !plants_[i].lit) continue;
    if (!plants_[i].cuts_building) gather_cuts(i, leaf_counts[i], allowance, builds);
    gather_meshes(i, allowance, builds);
  }
  return builds;
}

Result<Buffer> RasterPlants::upload(ListBuild& build, std::span<RasterList> headers) {
  COPPICE_TRY(buffer, create_buffer(*device_, build.bytes.size(), kAddressed, MemoryKind::device));
  for (std::size_t i = 0; i < build.headers.size(); ++i) {
    const auto& [clusters, leaves, splats] = build.addresses[i];
    headers[i] = build.headers[i];
    headers[i].clusters = gpu_address(buffer.address + clusters);
    headers[i].leaves = gpu_address(buffer.address + leaves);
    headers[i].splats = gpu_address(buffer.address + splats);
  }
  add_copy(buffer.buffer, 0, std::move(build.bytes));
  return buffer;
}

/// Takes a list's memory and the staging for it out of the room.
bool RasterPlants::take_room(RasterRoom& room, std::uint64_t list_bytes) {
  const std::uint64_t taken = device_bytes(room, list_bytes);
  if (taken > room.device_bytes) {
    lacking_bytes_ = std::max(lacking_bytes_, 2 * list_bytes);
    return false;
  }
  room.device_bytes -= taken;
  room.ring_bytes -= std::min(room.ring_bytes, taken == list_bytes ? list_bytes : 0);
  return true;
}

// Pages may have gone in the meantime, and with them the lists that these would follow on.
void RasterPlants::take_cuts(PlantLists& plant, ListBuild& build, RasterRoom& room) {
  plant.cuts_building = false;
  const auto count = static_cast<std::uint32_t>(build.leaf_counts.size());
  const bool follows = build.first == plant.record.level_count && build.leaf_counts.back() <= present_leaf_count(plant.pages);
  if (!follows || !take_room(room, build.bytes.size())) return;
  auto buffer = upload(build, std::span(plant.headers).subspan(build.first, count));
  if (!buffer) return go_on_without(*device_, buffer.error(), "leaves are drawn coarser, or by the hardware");
  plant.changed = true;
  plant.batches.push_back({*buffer, build.first, build.leaf_counts.back()});
  plant.record.level_count = build.first + count;
}

void RasterPlants::take_mesh(PlantLists& plant, ListBuild& build, RasterRoom& room) {
  MeshList& mesh = plant.meshes[build.first - kRasterLevels];
  if (!std::exchange(mesh.building, false) || build.headers.empty()) return;
  if (!take_room(room, build.bytes.size()) && build.first >= kRasterMeshes) {
    mesh.waiting = std::move(build.mesh);
    return;
  }
  auto buffer = upload(build, std::span(plant.headers).subspan(build.first, 1));
  if (!buffer) {
    mesh.waiting = std::move(build.mesh);
    return go_on_without(*device_, buffer.error(), "wood and leaf meshes are drawn by the hardware");
  }
  mesh.buffer = *buffer;
  plant.changed = true;
}

void RasterPlants::take_over(std::vector<ListBuild> builds, RasterRoom& room) {
  for (ListBuild& build : builds) {
    PlantLists& plant = plants_[build.plant];
    if (!plant.used || plant.generation != build.generation) continue;
    if (build.leaf_counts.empty())
      take_mesh(plant, build, room);
    else
      take_cuts(plant, build, room);
  }
}

void RasterPlants::fill_mesh_record(PlantLists& plant) {
  const auto is_there = [&](std::uint32_t list) { return plant.meshes[list].buffer.buffer != VK_NULL_HANDLE; };
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
  return std::max(lacking_bytes_, most_list_bytes(kLeavesPerJob));
}

void RasterPlants::update(std::span<const std::uint32_t> leaf_counts, RasterRoom room) {
  lacking_bytes_ = 0;
  const std::uint64_t kept_bytes = job_.kept_bytes();
  std::vector<ListBuild> built = job_.take();
  if (!job_.idle()) room.device_bytes -= std::min(room.device_bytes, kept_bytes);
  take_over(std::move(built), room);
  std::vector<ListBuild> small = gather(leaf_counts, {kLeavesAtOnce, kLeavesPerFrame, room});
  std::ranges::for_each(small, build_lists);
  take_over(std::move(small), room);
  if (job_.idle()) {
    job_.start(gather(leaf_counts, {~0u, kLeavesPerJob, room}), jobs_);
    take_over(job_.take(), room);  // of a hook that runs jobs inline
  }
  for (std::size_t i = 0; i < plants_.size(); ++i) {
    PlantLists& plant = plants_[i];
    if (std::exchange(plant.looks_changed, false)) {
      const PlantLooks& looks = *plant.source.looks;
      add_copy(plant.looks_buffer.buffer, 0, bytes_of(looks.looks));
      add_copy(plant.looks_buffer.buffer, looks.looks.size() * sizeof(RasterCard), bytes_of(looks.wood_colors));
    }
    if (!plant.changed) continue;
    if (plant.used) fill_mesh_record(plant);
    add_copy(plants_buffer_.buffer, i * sizeof(RasterPlant), bytes_of(std::vector{plant.record}));
    if (plant.used) add_copy(lists_.buffer, i * kRasterLists * sizeof(RasterList), bytes_of(plant.headers));
    plant.changed = false;
  }
}

std::size_t RasterPlants::bytes() const {
  std::size_t sum = job_.kept_bytes();
  // Pages that have been evicted while the job holds them; the others are counted where they are kept.
  for (const ListBuild& build : job_.builds())
    for (std::size_t page = 0; page < build.pages.size(); ++page) {
      const std::vector<SharedNodes>& there = plants_[build.plant].pages;
      if (page >= there.size() || there[page].owner != build.pages[page].owner) sum += build.pages[page].nodes.size_bytes();
    }
  for (const PlantLists& plant : plants_) {
    if (!plant.used) continue;
    sum += plant.pages.capacity() * sizeof(SharedNodes) + plant.source.light->cells.capacity() * sizeof(CrownSample);
    sum += plant.source.looks->wood_colors.capacity() * sizeof(std::uint32_t);
    for (const Texels& texels : plant.source.looks->small) sum += texels.rgba.capacity();
    for (std::uint32_t list = 0; list < kMeshLists; ++list) {
      const WoodMesh& mesh = plant.meshes[list].waiting;
      if (!mesh.indices.empty()) sum += list < kMaxWoodLods ? wood_bytes(mesh) : mesh_bytes(mesh);
    }
  }
  return sum;
}

}  // namespace coppice::gpu
