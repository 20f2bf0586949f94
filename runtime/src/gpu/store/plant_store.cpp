#include "plant_store.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "check.h"
#include "convert.h"
#include "frame_wind.h"
#include "leaf_entry.h"
#include "page_codec.h"

namespace coppice::gpu {
namespace {

constexpr VkBufferUsageFlags kAddressed =
    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

/// list: has space for all distinct ones
template <class T>
void add_distinct(BoundedList<T>& list, const T& value) {
  if (std::ranges::find(list.span(), value) == list.span().end()) list.push_back(value);
}

}  // namespace

Result<void> PlantStore::create() {
  COPPICE_CHECK(move_into(placeholder_.texture, create_texture(device_, {1, 1, 1, COPPICE_TEXTURE_RGBA8}, MemoryKind::lasting)));
  return move_into(placeholder_.set, texture_sets_.create_set(placeholder_.texture.view));
}

PlantStore::~PlantStore() {
  destroy(placeholder_);
  destroy_buffer(device_, partial_.buffer);
  destroy(partial_.texture);
  for (std::uint32_t i = 0; i < count_; ++i)
    if (plants_[i]) destroy(*plants_[i]);
}

Result<void> PlantStore::reserve(std::uint32_t count) {
  if (count <= plants_.size()) return {};
  HookArray<std::unique_ptr<StoredPlant>> larger;
  COPPICE_CHECK(allocate_into(larger, allocator_, count));
  std::ranges::move(plants_, larger.begin());
  plants_ = std::move(larger);
  return {};
}

const StoredTexture& PlantStore::shown_texture(std::uint32_t plant, std::uint32_t texture) const {
  const bool shown = texture != kNoTexture && plants_[plant]->textures[texture].visible;
  return shown ? plants_[plant]->textures[texture] : placeholder_;
}

Result<void> PlantStore::add(std::uint32_t index, const PlantFile& file, const PlantAppearance& appearance,
                             std::span<const std::uint32_t> lod_words) {
  COPPICE_ASSERT(index < plants_.size() && !plants_[index] && lod_words.size() <= kWindWord);
  std::unique_ptr<StoredPlant> plant(new (std::nothrow) StoredPlant);
  if (!plant) return Error{Status::out_of_memory, "plant"};
  COPPICE_CHECK(allocate_into(plant->pages, allocator_, file.plant.page_count));
  COPPICE_CHECK(allocate_into(plant->textures, allocator_, file.plant.texture_count));
  COPPICE_CHECK(allocate_into(plant->material_textures, allocator_, file.materials.size()));
  COPPICE_CHECK(plant->leaf_textures.make_room(allocator_, file.materials.size()));
  const WindField wind = wind_field(file);
  COPPICE_CHECK(allocate_into(plant->pending_words, allocator_, kWindWord + wind_word_count(wind)));
  std::ranges::copy(lod_words, plant->pending_words.begin());
  pack_wind(wind, plant->pending_words.span().subspan(kWindWord));
  plant->layout = place_plant_tables(file);
  COPPICE_CHECK(allocate_into(plant->pending_tables, allocator_, plant->layout.bytes));
  COPPICE_CHECK(move_into(plant->tables, create_buffer(device_, {"coppice plant", plant->layout.bytes, kAddressed})));
  plant->leaf_mesh_count = file.plant.leaf_mesh_count;
  if (auto filled = fill_tables(*plant, file, appearance); !filled) {
    destroy(*plant);
    return filled;
  }
  plants_[index] = std::move(plant);
  count_ = std::max(count_, index + 1);
  return {};
}

// A page or list that is not resident points at something readable: a shader may load from it before it finds that it need not.
Result<void> PlantStore::fill_tables(StoredPlant& plant, const PlantFile& file, const PlantAppearance& appearance) {
  const std::uint64_t base = plant.tables.address;
  const PlantTables& layout = plant.layout;
  plant.record = gpu_plant(file.plant);
  plant.record.cards = gpu_address(base + layout.cards_at);
  plant.record.materials = gpu_address(base + layout.materials_at);
  plant.record.card_looks = gpu_address(base + layout.looks_at);
  plant.record.crown_light = gpu_address(base + layout.crown_at);
  plant.record.lists = gpu_address(base + layout.lists_at);
  const auto write = [&](std::uint64_t at, std::size_t i, const auto& value) {
    std::memcpy(plant.pending_tables.data() + at + i * sizeof value, &value, sizeof value);
  };
  for (std::size_t i = 0; i < appearance.looks.looks.size(); ++i) write(layout.looks_at, i, appearance.looks.looks[i]);
  write(layout.crown_at, 0, appearance.light.words);
  for (std::size_t i = 0; i < file.materials.size(); ++i) {
    const Material material = gpu_material(file.materials[i]);
    write(layout.materials_at, i, material);
    plant.material_textures[i] = {material.texture, material.normal_map};
  }
  for (std::size_t i = 0; i < file.cards.size(); ++i) {
    write(layout.cards_at, i, gpu_card(file.cards[i]));
    add_distinct(plant.leaf_textures, plant.material_textures[file.cards[i].material].color);
  }
  for (std::uint32_t i = 0; i < std::max(file.plant.page_count, 1u); ++i) write(layout.pages_at, i, gpu_address(base));
  ClusterList list = empty_list(leaf_box(plant.record));
  list.leaf_count = file.plant.leaf_count;
  for (std::uint32_t i = 0; i < kClusterLists; ++i) {
    list.blocks = gpu_address(i == kPageList ? base + layout.pages_at : base);
    write(layout.lists_at, i, list);
  }
  return file.plant.page_count == 0 ? add_single_leaf(plant, file, appearance) : Result<void>();
}

// A plant of one leaf has no pages: its cuts are made here.
Result<void> PlantStore::add_single_leaf(StoredPlant& plant, const PlantFile& file, const PlantAppearance& appearance) {
  COPPICE_TRY(scratch, HookArray<ClusterScratch>::allocate(allocator_, 1));
  ReadyCuts cuts;
  COPPICE_CHECK(allocate_into(cuts.bytes, allocator_, ready_cut_bytes(1)));
  build_ready_cuts({root_node(file.plant), appearance.looks.cards(), leaf_box(plant.record), &appearance.light, 1}, {}, scratch[0], cuts);
  move_ready_cuts(1, cuts.lists, cuts.bytes.span(), plant.tables.address + plant.layout.cuts_at);
  std::memcpy(plant.pending_tables.data() + plant.layout.lists_at, cuts.lists.data(), sizeof cuts.lists);
  std::ranges::copy(cuts.bytes, plant.pending_tables.begin() + static_cast<std::ptrdiff_t>(plant.layout.cuts_at));
  plant.has_cuts = true;
  return {};
}

void PlantStore::remove(std::uint32_t index) {
  COPPICE_ASSERT(plants_[index]);
  deletion_.defer(plants_[index]->tables);
  destroy(*plants_[index]);
  plants_[index].reset();
}

void PlantStore::destroy(StoredPlant& plant) {
  destroy_buffer(device_, plant.tables);
  for (Buffer& page : plant.pages) destroy_buffer(device_, page);
  for (StoredMesh& mesh : plant.meshes) destroy_buffer(device_, mesh.buffer);
  for (StoredTexture& texture : plant.textures) destroy(texture);
}

void PlantStore::destroy(StoredTexture& texture) {
  destroy_texture(device_, texture.texture);
  destroy_set(device_, texture.set);
  texture = {};
}

/// Overwrites a part of the plant's tables, also in tables that are not uploaded yet: their copy in a later frame must not undo this.
Result<void> PlantStore::patch_tables(StoredPlant& plant, std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  COPPICE_CHECK(uploads_.patch(bytes, plant.tables, offset));
  if (!plant.pending_tables.empty()) std::memcpy(plant.pending_tables.data() + offset, bytes.data(), bytes.size());
  return {};
}

Result<void> PlantStore::patch_cuts(StoredPlant& plant, ReadyCuts& cuts) {
  move_ready_cuts(plant.record.leaf_count, cuts.lists, cuts.bytes.span(), plant.tables.address + plant.layout.cuts_at);
  COPPICE_CHECK(patch_tables(plant, plant.layout.lists_at, bytes_of(std::span<const ClusterList>(cuts.lists))));
  return patch_tables(plant, plant.layout.cuts_at, cuts.bytes.span());
}

template <class Stage>
Result<void> PlantStore::upload(Buffer& place, const BufferDesc& desc, Stage stage) {
  COPPICE_ASSERT(place.buffer == VK_NULL_HANDLE);
  COPPICE_TRY(buffer, create_buffer(device_, desc));
  const Uploads::Mark mark = uploads_.mark();
  if (Result<void> staged = stage(buffer); !staged) {
    uploads_.undo(mark);
    destroy_buffer(device_, buffer);
    return staged;
  }
  place = buffer;
  return {};
}

// Tables are patched last, because they name staged data and nothing may fail afterwards.
Result<void> PlantStore::upload_page(const PageUpload& upload_of) {
  StoredPlant& plant = *plants_[upload_of.plant];
  COPPICE_ASSERT(upload_of.clusters.size() == kPageBytes);
  const auto stage = [&](const Buffer& page) -> Result<void> {
    move_clusters(upload_of.clusters, kBlockClusters, page.address);
    COPPICE_CHECK(uploads_.copy(upload_of.clusters, page, 0));
    if (upload_of.page == 0) COPPICE_CHECK(patch_cuts(plant, *upload_of.ready_cuts));
    const uvec2 address = gpu_address(page.address);
    return patch_tables(plant, plant.layout.pages_at + upload_of.page * sizeof address, bytes_of(std::span(&address, 1)));
  };
  const MemoryKind kind = upload_of.page == 0 ? MemoryKind::lasting : MemoryKind::device;
  COPPICE_CHECK(upload(plant.pages[upload_of.page], {"coppice page", kPageBytes, kAddressed, kind}, stage));
  plant.has_cuts = plant.has_cuts || upload_of.page == 0;
  plant.has_transparency =
      plant.has_transparency || has_transparency(upload_of.clusters) || (upload_of.page == 0 && upload_of.ready_cuts->has_transparency);
  return {};
}

// What has been recorded of it writes on.
void PlantStore::abandon(PartialUpload& upload_of) {
  deletion_.defer(upload_of.buffer);
  deletion_.defer(upload_of.texture.set);
  deletion_.defer(upload_of.texture.texture);
  upload_of = {};
}

void PlantStore::abandon_upload() {
  abandon(partial_);
}

// Tables are patched last, because they name staged data.
Result<bool> PlantStore::continue_mesh(PartialUpload& part, const MeshUpload& upload_of, std::uint64_t max_bytes) {
  StoredPlant& plant = *plants_[upload_of.plant];
  MeshBlock& block = *upload_of.block;
  const std::span<const std::uint8_t> bytes = block.bytes.span();
  if (part.buffer.buffer == VK_NULL_HANDLE) {
    COPPICE_CHECK(plant.meshes[upload_of.mesh].textures.make_room(allocator_, plant.material_textures.size()));
    constexpr VkBufferUsageFlags kUsage = kAddressed | VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
    const MemoryKind kind = upload_of.mesh + 1 == plant.record.wood_lod_count ? MemoryKind::lasting : MemoryKind::device;  // the coarsest
    COPPICE_CHECK(move_into(part.buffer, create_buffer(device_, {"coppice mesh", bytes.size(), kUsage, kind})));
    block.move(part.buffer.address);
  }
  const std::uint64_t count = std::min(bytes.size() - part.copied_bytes, max_bytes);
  COPPICE_CHECK(uploads_.copy(bytes.subspan(part.copied_bytes, count), part.buffer, part.copied_bytes));
  part.copied_bytes += count;
  if (part.copied_bytes < bytes.size()) return false;
  COPPICE_CHECK(patch_tables(plant, plant.layout.lists_at + (kWoodLists + upload_of.mesh) * sizeof(ClusterList),
                             bytes_of(std::span<const ClusterList>(&block.list, 1))));
  return true;
}

Result<bool> PlantStore::upload_mesh(const MeshUpload& upload_of, std::uint64_t max_bytes) {
  StoredPlant& plant = *plants_[upload_of.plant];
  StoredMesh& mesh = plant.meshes[upload_of.mesh];
  const MeshBlock& block = *upload_of.block;
  COPPICE_ASSERT(mesh.buffer.buffer == VK_NULL_HANDLE);
  PartialUpload whole;
  PartialUpload& part = max_bytes == kWhole ? whole : partial_;
  const auto done = continue_mesh(part, upload_of, max_bytes);
  if (!done) abandon(part);
  if (!done || !*done) return done;
  mesh.buffer = std::exchange(part, {}).buffer;
  mesh.vertices = gpu_address(mesh.buffer.address + block.vertices_at);
  mesh.index_count = block.index_count;
  mesh.cluster_count = block.list.cluster_count;
  mesh.textures.clear();
  for (std::size_t material = 0; material < plant.material_textures.size(); ++material)
    if (block.materials[material]) add_distinct(mesh.textures, plant.material_textures[material]);
  return true;
}

Result<bool> PlantStore::continue_texture(PartialUpload& part, std::span<const std::uint8_t> bytes, std::uint64_t max_bytes) {
  const std::span<const std::uint8_t> texels = bytes.subspan(sizeof(coppice_file_texture));
  if (part.texture.texture.image == VK_NULL_HANDLE) {
    coppice_file_texture header{};
    std::memcpy(&header, bytes.data(), sizeof header);
    COPPICE_CHECK(move_into(part.texture.texture, create_texture(device_, header, MemoryKind::device)));
    COPPICE_CHECK(move_into(part.texture.set, texture_sets_.create_set(part.texture.texture.view)));
  }
  COPPICE_CHECK(move_into(part.copied_bytes, uploads_.fill(part.texture.texture, texels, part.copied_bytes, max_bytes)));
  return part.copied_bytes == texels.size();
}

Result<bool> PlantStore::upload_texture(std::uint32_t plant, std::uint32_t index, std::span<const std::uint8_t> bytes,
                                        std::uint64_t max_bytes) {
  COPPICE_TRY(layout, read_texture(bytes));
  if (layout.format != COPPICE_TEXTURE_RGBA8 && !device_.block_textures)
    return Error{Status::unsupported, "a texture in blocks, without textureCompressionBC"};
  PartialUpload whole;
  PartialUpload& part = max_bytes == kWhole ? whole : partial_;
  const auto done = continue_texture(part, bytes, max_bytes);
  if (!done) abandon(part);
  if (!done || !*done) return done;
  plants_[plant]->textures[index] = std::exchange(part, {}).texture;
  plants_[plant]->textures[index].visible = true;
  return true;
}

Result<void> PlantStore::upload_tables(const Buffer& words) {
  if (!placeholder_.visible) {
    constexpr std::uint8_t kWhite[4] = {255, 255, 255, 255};
    COPPICE_CHECK(uploads_.fill(placeholder_.texture, kWhite, 0, sizeof kWhite));
    placeholder_.visible = true;
  }
  for (std::uint32_t i = 0; i < count_; ++i) {
    if (!plants_[i] || plants_[i]->pending_tables.empty()) continue;
    StoredPlant& plant = *plants_[i];
    COPPICE_CHECK(uploads_.copy(plant.pending_tables.span(), plant.tables, 0));
    COPPICE_CHECK(uploads_.copy(bytes_of(std::span<const std::uint32_t>(plant.pending_words.span())), words,
                                std::uint64_t{i} * kTableStride * sizeof(std::uint32_t)));
    plant.pending_tables = {};
    plant.pending_words = {};
  }
  return {};
}

void PlantStore::drop_page(std::uint32_t plant, std::uint32_t page) {
  destroy_buffer(device_, plants_[plant]->pages[page]);
}

void PlantStore::drop_mesh(std::uint32_t plant, std::uint32_t index) {
  StoredMesh& mesh = plants_[plant]->meshes[index];
  destroy_buffer(device_, mesh.buffer);
  mesh = {};
}

void PlantStore::drop_texture(std::uint32_t plant, std::uint32_t texture) {
  destroy(plants_[plant]->textures[texture]);
}

}  // namespace coppice::gpu
