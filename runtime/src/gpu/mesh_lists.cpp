#include "mesh_lists.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace coppice::gpu {
namespace {

constexpr VkBufferUsageFlags kAddressed =
    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

/// Triangles that one job builds, about 7 ms of a core; a mesh that has more is built all the same.
constexpr std::uint64_t kTrianglesPerJob = 16384;

template <class T>
std::vector<std::uint8_t> bytes_of(std::span<const T> values) {
  std::vector<std::uint8_t> bytes(values.size_bytes());
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::uint32_t triangle_count(const WoodMesh& mesh) {
  return static_cast<std::uint32_t>(mesh.indices.size() / 3);
}

std::uint64_t own_bytes(const WoodMesh& mesh) {
  return mesh.vertices.size() * sizeof(coppice::WoodVertex) + mesh.indices.size() * sizeof(std::uint32_t);
}

/// What a list's memory and the staging for it take of the room.
std::uint64_t device_bytes(const MeshRoom& room, std::uint64_t list_bytes) {
  return list_bytes <= room.ring_bytes ? list_bytes : 2 * list_bytes;
}

}  // namespace

MeshLists::~MeshLists() {
  for (PlantMeshes& plant : plants_) {
    for (Mesh& mesh : plant.meshes)
      if (mesh.buffer.buffer != VK_NULL_HANDLE) destroy_buffer(device_, mesh.buffer);
    if (plant.looks_buffer.buffer != VK_NULL_HANDLE) destroy_buffer(device_, plant.looks_buffer);
  }
}

Result<void> MeshLists::add_plant(std::uint32_t index, const PlantFile& file, const ListPlace& lists) {
  if (index >= plants_.size()) plants_.resize(index + 1);
  PlantMeshes plant;
  const auto looks = std::make_shared<PlantLooks>(plain_looks(file));
  COPPICE_TRY(buffer, create_buffer(device_, looks->looks.size() * sizeof(CardLook) + looks->wood_colors.size() * sizeof(std::uint32_t),
                                    kAddressed, MemoryKind::device));
  plant.used = plant.looks_changed = true;
  plant.generation = ++last_generation_;
  plant.source = {looks, nullptr, leaf_box(gpu_plant(file.plant))};
  plant.texture_taken.resize(file.plant.texture_count);
  plant.lists = lists;
  plant.looks_buffer = buffer;
  plant.leaf_mesh_count = file.plant.leaf_mesh_count;
  plants_[index] = std::move(plant);
  return {};
}

void MeshLists::remove_plant(std::uint32_t index, std::uint64_t last_frame) {
  PlantMeshes& plant = plants_[index];
  if (!plant.used) return;
  for (const Mesh& mesh : plant.meshes)
    if (mesh.buffer.buffer != VK_NULL_HANDLE) retire(mesh.buffer, last_frame);
  retire(plant.looks_buffer, last_frame);
  std::erase_if(copies_, [&](const MeshCopy& copy) { return copy.to == plant.lists.buffer; });
  plant = {};
}

std::uint64_t MeshLists::mesh_bytes(const WoodMesh& mesh) {
  return own_bytes(mesh) + most_mesh_cluster_bytes(triangle_count(mesh));
}

void MeshLists::add_mesh(std::uint32_t plant, std::uint32_t list, const WoodMesh& mesh) {
  Mesh& added = this->mesh(plant, list);
  added.waiting = mesh;
  // What a texture covers is built into the list of wood; the colour of what it covers is looked up, so that nothing else waits.
  const bool is_wood = list < kMeshLists;
  for (const coppice::WoodVertex& vertex : mesh.vertices)
    if (!is_wood || is_masked(plants_[plant].source.looks->materials[vertex.material])) added.materials.insert(vertex.material);
}

void MeshLists::set_light(std::uint32_t plant, std::shared_ptr<const CrownLight> light) {
  plants_[plant].source.light = std::move(light);
}

void MeshLists::drop_mesh(std::uint32_t plant, std::uint32_t list, std::uint64_t last_frame) {
  if (!plants_[plant].used) return;
  const Mesh dropped = std::exchange(mesh(plant, list), {});
  if (dropped.buffer.buffer != VK_NULL_HANDLE) retire(dropped.buffer, last_frame);
}

void MeshLists::add_texture(std::uint32_t index, std::uint32_t texture, std::span<const std::uint8_t> chunk) {
  PlantMeshes& plant = plants_[index];
  if (plant.texture_taken[texture]) return;
  auto looks = std::make_shared<PlantLooks>(*plant.source.looks);
  take_texture(*looks, texture, chunk);
  plant.source.looks = std::move(looks);
  plant.texture_taken[texture] = plant.looks_changed = true;
}

void MeshLists::add_copy(VkBuffer to, std::uint64_t offset, std::vector<std::uint8_t> bytes) {
  std::erase_if(copies_, [&](const MeshCopy& copy) { return copy.to == to && copy.offset == offset; });
  copies_.push_back({to, offset, std::move(bytes)});
}

void MeshLists::retire(const Buffer& buffer, std::uint64_t last_frame) {
  std::erase_if(copies_, [&](const MeshCopy& copy) { return copy.to == buffer.buffer; });
  garbage_.retire(last_frame, buffer);
}

/// Takes a list's memory and the staging for it out of the room.
bool MeshLists::take_room(MeshRoom& room, std::uint64_t list_bytes) {
  const std::uint64_t taken = device_bytes(room, list_bytes);
  if (taken > room.device_bytes) {
    lacking_bytes_ = std::max(lacking_bytes_, 2 * list_bytes);
    return false;
  }
  room.device_bytes -= taken;
  room.ring_bytes -= std::min(room.ring_bytes, taken == list_bytes ? list_bytes : 0);
  return true;
}

std::vector<MeshBuild> MeshLists::gather(MeshRoom room) {
  std::vector<MeshBuild> builds;
  std::uint64_t triangles_left = kTrianglesPerJob;
  for (std::uint32_t i = 0; i < plants_.size(); ++i) {
    PlantMeshes& plant = plants_[i];
    if (!plant.used || !plant.source.light) continue;
    for (std::uint32_t list = kWoodLists; list < kClusterLists && triangles_left > 0; ++list) {
      Mesh& mesh = this->mesh(i, list);
      const std::uint32_t triangles = triangle_count(mesh.waiting);
      if (triangles == 0) continue;
      if (!std::ranges::all_of(mesh.materials, [&](std::uint32_t material) { return has_texels(*plant.source.looks, material); })) continue;
      // Wood has had its room kept since it was uploaded; leaf meshes wait for theirs.
      if (list >= kMeshLists && !take_room(room, most_mesh_cluster_bytes(triangles))) continue;
      MeshBuild& build = builds.emplace_back();
      build.plant = i;
      build.generation = plant.generation;
      build.list = list;
      build.source = plant.source;
      build.kept_bytes = mesh_bytes(mesh.waiting);
      build.mesh = std::exchange(mesh.waiting, {});
      mesh.building = true;
      triangles_left -= std::min<std::uint64_t>(triangles_left, triangles);
    }
  }
  return builds;
}

void MeshLists::take_mesh(MeshBuild& build, MeshRoom& room) {
  PlantMeshes& plant = plants_[build.plant];
  Mesh& mesh = this->mesh(build.plant, build.list);
  MeshClusters& clusters = build.clusters;
  if (!std::exchange(mesh.building, false) || clusters.list.leaf_count == 0) return;
  if (!take_room(room, clusters.bytes.size()) && build.list >= kMeshLists) {
    mesh.waiting = std::move(build.mesh);
    return;
  }
  auto buffer = create_buffer(device_, clusters.bytes.size(), kAddressed, MemoryKind::device);
  if (!buffer) {
    mesh.waiting = std::move(build.mesh);
    return go_on_without(device_, buffer.error(), "wood and leaf meshes are drawn by the hardware");
  }
  mesh.buffer = *buffer;
  clusters.move(buffer->address);
  mesh.header = clusters.list;
  add_copy(plant.lists.buffer, plant.lists.offset + build.list * sizeof(ClusterList), bytes_of(std::span(&std::as_const(mesh.header), 1)));
  add_copy(buffer->buffer, 0, std::move(clusters.bytes));
}

void MeshLists::take_over(std::vector<MeshBuild> builds, MeshRoom& room) {
  for (MeshBuild& build : builds)
    if (plants_[build.plant].used && plants_[build.plant].generation == build.generation) take_mesh(build, room);
}

void MeshLists::fill_record(std::uint32_t index, Plant& record) const {
  const PlantMeshes& plant = plants_[index];
  const auto is_there = [&](std::uint32_t list) { return plant.meshes[list - kWoodLists].buffer.buffer != VK_NULL_HANDLE; };
  record.card_looks = gpu_address(plant.looks_buffer.address);
  record.wood_colors = gpu_address(plant.looks_buffer.address + plant.source.looks->looks.size() * sizeof(CardLook));
  record.wood_list_mask = record.mesh_cluster_count = 0;
  for (std::uint32_t lod = 0; lod < kMaxWoodLods; ++lod)
    if (is_there(kWoodLists + lod)) record.wood_list_mask |= 1u << lod;
  record.mesh_list_count = plant.leaf_mesh_count;
  for (std::uint32_t chunk = 0; chunk < plant.leaf_mesh_count; ++chunk) {
    record.mesh_cluster_count += plant.meshes[kMeshLists - kWoodLists + chunk].header.cluster_count;
    if (!is_there(kMeshLists + chunk)) record.mesh_list_count = 0;
  }
}

std::uint64_t MeshLists::wanted_bytes() const {
  return std::max(lacking_bytes_, most_mesh_cluster_bytes(kTrianglesPerJob));
}

void MeshLists::update(MeshRoom room) {
  lacking_bytes_ = 0;
  const std::uint64_t kept_bytes = job_.kept_bytes();
  std::vector<MeshBuild> built = job_.take();
  if (!job_.idle()) room.device_bytes -= std::min(room.device_bytes, kept_bytes);
  take_over(std::move(built), room);
  if (job_.idle()) {
    job_.start(gather(room), jobs_);
    take_over(job_.take(), room);  // of a hook that runs jobs inline
  }
  for (PlantMeshes& plant : plants_) {
    if (!std::exchange(plant.looks_changed, false)) continue;
    const PlantLooks& looks = *plant.source.looks;
    add_copy(plant.looks_buffer.buffer, 0, bytes_of(std::span(looks.looks)));
    add_copy(plant.looks_buffer.buffer, looks.looks.size() * sizeof(CardLook), bytes_of(std::span(looks.wood_colors)));
  }
}

std::size_t MeshLists::bytes() const {
  std::size_t sum = job_.kept_bytes();
  for (const PlantMeshes& plant : plants_) {
    if (!plant.used) continue;
    if (plant.source.light) sum += plant.source.light->cells.capacity() * sizeof(CrownSample);
    sum += plant.source.looks->wood_colors.capacity() * sizeof(std::uint32_t);
    for (const Texels& texels : plant.source.looks->small) sum += texels.rgba.capacity();
    for (std::uint32_t list = 0; list < kLists; ++list) {
      const WoodMesh& mesh = plant.meshes[list].waiting;
      if (!mesh.indices.empty()) sum += list < kMaxWoodLods ? mesh_bytes(mesh) : own_bytes(mesh);
    }
  }
  return sum;
}

}  // namespace coppice::gpu
