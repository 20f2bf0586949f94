#include "renderer.h"

#include <algorithm>
#include <cstring>
#include <new>

#include "check.h"
#include "convert.h"
#include "page_codec.h"

namespace coppice::gpu {
namespace {

constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
constexpr std::uint64_t kStagingBytes = 8ull << 20;
/// Kept free in the staging ring for what is no chunk: instances, tables, lists.
constexpr std::uint64_t kFrameStagingBytes = 1ull << 19;
/// The rasteriser's lists may grow by one part in this many of the budget in a frame, or more where one list is larger.
constexpr std::uint64_t kListShare = 32;
/// Devices promise 4,096 allocations; the pool takes at most about this many.
constexpr std::uint64_t kMaxPoolBlocks = 256;

std::uint32_t pool_block_pages(std::uint64_t budget_bytes) {
  return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(budget_bytes / (kMaxPoolBlocks * kPageBytes), 16, 4096));
}

void add_distinct(std::vector<std::uint32_t>& values, std::uint32_t value) {
  if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
}

std::uint64_t round_up_16(std::uint64_t bytes) {
  return (bytes + 15) / 16 * 16;
}

std::uint64_t with_margin(std::uint64_t bytes) {
  return bytes + bytes / 4;
}

}  // namespace

Renderer::Renderer(const RendererDesc& desc) : device_(desc.device), desc_(desc) {
  pages_.configure(pool_block_pages(desc.memory_budget_bytes));
}

Result<std::unique_ptr<Renderer>> Renderer::create(const RendererDesc& desc) {
  std::unique_ptr<Renderer> renderer(new (std::nothrow) Renderer(desc));
  if (!renderer) return Error{Status::out_of_memory, "renderer"};
  if (desc.max_instances > std::uint64_t{renderer->device_.max_group_count} * kCullGroupSize)
    return Error{Status::unsupported, "max_instances beyond what the device culls in one dispatch", Error::kNoOffset,
                 std::to_string(desc.max_instances)};
  if (std::uint64_t{desc.max_instances} * sizeof(Instance) > renderer->device_.max_storage_bytes)
    return Error{Status::unsupported, "max_instances beyond what a storage buffer of the device holds", Error::kNoOffset,
                 std::to_string(desc.max_instances)};
  COPPICE_CHECK(create_passes(renderer->device_, desc.attachments, desc.pipeline_cache, renderer->passes_));
  COPPICE_TRY(staging, Staging::create(renderer->device_, kStagingBytes));
  renderer->staging_ = std::move(staging);
  COPPICE_CHECK(renderer->create_default_texture());
  COPPICE_CHECK(renderer->create_fixed_buffers());
  if (desc.pass_times) COPPICE_CHECK(renderer->timer_.create(renderer->device_));
  if (!desc.compute_raster) return renderer;
  auto raster = LeafRaster::create(renderer->device_, renderer->garbage_,
                                   {.attachments = desc.attachments,
                                    .pipeline_cache = desc.pipeline_cache,
                                    .frame_set_layout = renderer->passes_.frame_set_layout,
                                    .max_instances = desc.max_instances,
                                    .int64_atomics = desc.int64_atomics,
                                    .many_lanes = desc.many_lanes,
                                    .jobs = desc.jobs});
  if (raster) {
    renderer->raster_ = *std::move(raster);
  } else if (raster.error().status == Status::unsupported) {
    go_on_without(renderer->device_, raster.error(), "all plants are drawn by the hardware");
  } else {
    return raster.error();
  }
  return renderer;
}

Renderer::~Renderer() {
  garbage_.collect(device_, ~std::uint64_t{0});
  for (PlantSlot& plant : plants_)
    if (plant.used) destroy_plant(plant);
  raster_.reset();
  timer_.destroy(device_);
  garbage_.collect(device_, ~std::uint64_t{0});
  pages_.destroy(device_);
  staging_.destroy(device_);
  for (Buffer* buffer :
       {&fixed_.view, &fixed_.instances, &fixed_.plants, &fixed_.tables, &fixed_.cuts, &fixed_.leaf_counts, &fixed_.wood_commands,
        &fixed_.counters, &fixed_.indices, &fixed_.readback, &fixed_.debug_colors, &leaf_commands_, &wood_list_})
    if (buffer->buffer != VK_NULL_HANDLE) destroy_buffer(device_, *buffer);
  if (default_texture_.image != VK_NULL_HANDLE) destroy_texture(device_, default_texture_);
  device_.vk.vkDestroyDescriptorPool(device_.device, frame_set_.pool, nullptr);
  device_.vk.vkDestroyDescriptorPool(device_.device, shadowed_set_.pool, nullptr);
  device_.vk.vkDestroyDescriptorPool(device_.device, default_set_.pool, nullptr);
  destroy_passes(device_, passes_);
}

Result<void> Renderer::create_fixed_buffers() {
  struct Wanted {
    Buffer* buffer;
    std::uint64_t bytes;
    VkBufferUsageFlags usage;
    MemoryKind kind = MemoryKind::device;
  };
  const std::uint64_t instances = desc_.max_instances;
  const std::uint64_t plants = desc_.max_plants;
  const Wanted wanted[] = {
      {&fixed_.view, sizeof(View), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT},
      {&fixed_.instances, instances * sizeof(Instance), kStorage},
      {&fixed_.plants, plants * sizeof(Plant), kStorage},
      {&fixed_.tables, plants * kTableStride * sizeof(std::uint32_t),
       VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT},
      {&fixed_.cuts, instances * sizeof(float), kStorage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT},
      {&fixed_.leaf_counts, 2 * plants * sizeof(std::uint32_t), kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT},
      {&fixed_.wood_commands, plants * kMeshCommands * sizeof(DrawCommand), kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT},
      {&fixed_.counters, sizeof(Counters), kStorage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT},
      {&fixed_.indices, std::uint64_t{kClusterLeaves} * 6 * sizeof(std::uint16_t),
       VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT},
      {&fixed_.readback, kReadbackSlots * sizeof(Counters), VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::host},
      {&fixed_.debug_colors, instances * sizeof(std::uint32_t), kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT},
  };
  for (const Wanted& item : wanted) {
    COPPICE_TRY(buffer, create_buffer(device_, item.bytes, item.usage, item.kind));
    *item.buffer = buffer;
  }
  COPPICE_CHECK(grow(leaf_commands_, 1024 * sizeof(DrawCommand)));
  COPPICE_CHECK(grow(wood_list_, 1024 * sizeof(std::uint32_t)));
  return rebuild_frame_set();
}

Result<void> Renderer::create_default_texture() {
  COPPICE_TRY(texture, create_texture(device_, {1, 1, 1, COPPICE_TEXTURE_RGBA8}));
  default_texture_ = texture;
  COPPICE_TRY(set, create_texture_set(device_, passes_, texture.view));
  default_set_ = set;
  return {};
}

Result<void> Renderer::grow(Buffer& buffer, std::uint64_t bytes) {
  if (bytes > room_bytes()) {
    lacking_bytes_ = std::max(lacking_bytes_, bytes);
    return Error{Status::out_of_memory, "memory budget: no room for draw commands now"};
  }
  COPPICE_TRY(larger, create_buffer(device_, bytes, kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, MemoryKind::device));
  if (buffer.buffer != VK_NULL_HANDLE) garbage_.retire(frame_, buffer);
  buffer = larger;
  frame_set_stale_ = true;
  return {};
}

FrameBindings Renderer::frame_bindings() const {
  FrameBindings bindings{.buffers = {&fixed_.view, &fixed_.instances, &fixed_.plants, &fixed_.tables, &fixed_.cuts, &wood_list_,
                                     &leaf_commands_, &fixed_.leaf_counts, &fixed_.wood_commands, &fixed_.counters}};
  bindings.maps.fill(default_texture_.view);
  return bindings;
}

Result<void> Renderer::rebuild_frame_set() {
  COPPICE_TRY(set, create_frame_set(device_, passes_, frame_bindings()));
  for (DescriptorSet* old : {&frame_set_, &shadowed_set_})
    if (old->pool != VK_NULL_HANDLE) garbage_.retire(frame_, old->pool);
  frame_set_ = set;
  shadowed_set_ = {};
  frame_set_stale_ = false;
  return {};
}

// Set 0 with the view's shadow maps; without them where memory is short.
VkDescriptorSet Renderer::set_of(const coppice_view& view) {
  if (view.shadow_cascade_count == 0) return frame_set_.set;
  FrameBindings bindings = frame_bindings();
  for (std::uint32_t i = 0; i < view.shadow_cascade_count; ++i) bindings.maps[i] = view.shadow_cascades[i].image;
  if (shadowed_set_.pool != VK_NULL_HANDLE && bindings.maps == maps_) return shadowed_set_.set;
  auto set = create_frame_set(device_, passes_, bindings);
  if (!set) {
    go_on_without(device_, set.error(), "drawn without shadows");
    return frame_set_.set;
  }
  if (shadowed_set_.pool != VK_NULL_HANDLE) garbage_.retire(frame_, shadowed_set_.pool);
  shadowed_set_ = *set;
  maps_ = bindings.maps;
  return shadowed_set_.set;
}

void Renderer::begin_frame(std::uint64_t frame_number, std::uint64_t completed_number) {
  frame_ = frame_number;
  completed_ = completed_number;
  drawable_ = false;
  most_overhead_bytes_ = ~std::uint64_t{0};
  garbage_.collect(device_, completed_);
  staging_.recycle(completed_);
  if (timer_.exists()) timer_.collect(device_, completed_);
  for (std::uint32_t slot = 0; slot < kReadbackSlots; ++slot) {
    const std::uint64_t frame = readback_frames_[slot];
    if (frame == 0 || frame > completed_ || frame < counts_.frame) continue;
    Counters sums;
    std::copy_n(fixed_.readback.mapped + slot * sizeof(Counters), sizeof(Counters), reinterpret_cast<std::uint8_t*>(&sums));
    counts_ = {.frame = frame,
               .visible_instances = sums.visible_instances,
               .occluded_instances = sums.occluded_instances,
               .leaves = sums.leaves[0] | std::uint64_t{sums.leaves[1]} << 32,
               .wood_triangles = sums.wood_triangles[0] | std::uint64_t{sums.wood_triangles[1]} << 32,
               .leaf_mesh_instances = sums.leaf_mesh_instances,
               .leaf_mesh_triangles = sums.leaf_mesh_triangles[0] | std::uint64_t{sums.leaf_mesh_triangles[1]} << 32,
               .hardware_triangles = sums.hardware_triangles[0] | std::uint64_t{sums.hardware_triangles[1]} << 32};
  }
}

Result<void> Renderer::add_plant(std::uint32_t index, const PlantFile& file, std::span<const std::uint32_t> lod_words) {
  COPPICE_ASSERT(index < desc_.max_plants && lod_words.size() <= kTableStride);
  if (index >= plants_.size()) {
    plants_.resize(index + 1);
    records_.resize(index + 1);
    plant_counts_.resize(index + 1);
    wood_templates_.resize(std::size_t{index + 1} * kMeshCommands);
  }
  PlantSlot& plant = plants_[index];
  COPPICE_ASSERT(!plant.used);
  const std::uint64_t cards_bytes = round_up_16(file.cards.size() * sizeof(Card));
  const std::uint64_t materials_bytes = round_up_16(file.materials.size() * sizeof(Material));
  const std::vector<std::uint32_t> unmeasured = pack_crown(CrownLight{});
  plant = {};
  plant.pages_offset = cards_bytes + materials_bytes;
  plant.crown_offset = plant.pages_offset + std::max<std::uint64_t>(file.plant.page_count, 1) * sizeof(uvec2);
  plant.lists_offset = plant.crown_offset + unmeasured.size() * sizeof(std::uint32_t);
  plant.cuts_offset = round_up_16(plant.lists_offset + kClusterLists * sizeof(ClusterList));
  COPPICE_TRY(tables, create_buffer(device_, plant.cuts_offset + ready_cut_bytes(file.plant.leaf_count),
                                    kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, MemoryKind::device));
  plant.used = true;
  plant.tables = tables;
  plant.record = gpu_plant(file.plant);
  plant.record.cards = gpu_address(tables.address);
  plant.record.materials = gpu_address(tables.address + cards_bytes);
  plant.record.crown_light = gpu_address(tables.address + plant.crown_offset);
  plant.record.lists = gpu_address(tables.address + plant.lists_offset);
  plant.page_slots.assign(file.plant.page_count, PagePool::kNoSlot);
  plant.textures.resize(file.plant.texture_count);
  plant.leaf_mesh_count = file.plant.leaf_mesh_count;

  plant.pending_tables.resize(tables.size_bytes);
  std::memcpy(plant.pending_tables.data() + plant.crown_offset, unmeasured.data(), plant.lists_offset - plant.crown_offset);
  // A page or list that is not there points at something readable: a shader may load from it before it finds that it need not.
  const uvec2 readable = gpu_address(tables.address);
  for (std::uint64_t at = plant.pages_offset; at < plant.crown_offset; at += sizeof readable)
    std::memcpy(plant.pending_tables.data() + at, &readable, sizeof readable);
  const LeafBox box = leaf_box(plant.record);
  ClusterList pages = ListFrame(box).empty_list();
  pages.leaf_count = file.plant.leaf_count;
  for (std::uint32_t i = 0; i < kClusterLists; ++i) {
    pages.blocks = gpu_address(tables.address + (i == kPageList ? plant.pages_offset : 0));
    std::memcpy(plant.pending_tables.data() + plant.lists_offset + i * sizeof pages, &pages, sizeof pages);
  }
  for (std::size_t i = 0; i < file.cards.size(); ++i) {
    const Card card = gpu_card(file.cards[i]);
    std::copy_n(reinterpret_cast<const std::uint8_t*>(&card), sizeof card, plant.pending_tables.data() + i * sizeof card);
    const Material material = gpu_material(file.materials[card.material]);
    add_distinct(plant.leaf_textures, material.texture);
  }
  for (std::size_t i = 0; i < file.materials.size(); ++i) {
    const Material material = gpu_material(file.materials[i]);
    std::copy_n(reinterpret_cast<const std::uint8_t*>(&material), sizeof material,
                plant.pending_tables.data() + cards_bytes + i * sizeof material);
    plant.material_textures.push_back({material.texture, material.normal_map});
  }
  plant.pending_words.assign(lod_words.begin(), lod_words.end());
  auto added = raster_ ? raster_->meshes().add_plant(index, file, {tables.buffer, plant.lists_offset}) : Result<void>();
  if (added && file.plant.page_count == 0) added = add_single_leaf(index, file);
  if (!added) remove_plant(index);
  return added;
}

/// With the addresses that they have on the device.
Renderer::PlacedCuts Renderer::place_cuts(const PlantSlot& plant, const ReadyCuts& cuts) {
  PlacedCuts placed{cuts.lists, {cuts.bytes.begin(), cuts.bytes.end()}};
  move_ready_cuts(plant.record.leaf_count, placed.lists, placed.bytes, plant.tables.address + plant.cuts_offset);
  return placed;
}

// A plant of one leaf has no pages: its cuts are made here.
Result<void> Renderer::add_single_leaf(std::uint32_t index, const PlantFile& file) {
  const std::vector<CardLook> looks = card_looks(file);
  const auto light = std::make_shared<CrownLight>();
  const auto scratch = std::make_unique<ClusterScratch>();
  ReadyCuts cuts;
  COPPICE_CHECK(allocate_into(cuts.bytes, default_allocator(), ready_cut_bytes(1)));
  build_ready_cuts({root_node(file.plant), looks, leaf_box(plants_[index].record), light.get(), 1}, {}, *scratch, cuts);
  PlantSlot& plant = plants_[index];
  const PlacedCuts placed = place_cuts(plant, cuts);
  std::memcpy(plant.pending_tables.data() + plant.lists_offset, placed.lists.data(), sizeof placed.lists);
  std::ranges::copy(placed.bytes, plant.pending_tables.begin() + static_cast<std::ptrdiff_t>(plant.cuts_offset));
  plant.has_cuts = true;
  if (raster_) raster_->meshes().set_light(index, light);
  return {};
}

void Renderer::remove_plant(std::uint32_t index) {
  COPPICE_ASSERT(plants_[index].used);
  destroy_plant(plants_[index]);
  if (raster_) raster_->meshes().remove_plant(index, frame_);
}

void Renderer::destroy_plant(PlantSlot& plant) {
  garbage_.retire(frame_, plant.tables);
  for (std::uint32_t slot : plant.page_slots)
    if (slot != PagePool::kNoSlot) {
      pages_.free(device_, slot);
      charged_bytes_ -= kPageBytes;
    }
  const auto retire = [this](const MeshBuffer& mesh) {
    if (mesh.buffer.buffer == VK_NULL_HANDLE) return;
    garbage_.retire(frame_, mesh.buffer);
    charged_bytes_ -= mesh.charged_bytes;
  };
  std::ranges::for_each(plant.wood, retire);
  std::ranges::for_each(plant.leaf_meshes, retire);
  for (PlantTexture& texture : plant.textures) {
    if (texture.texture.image == VK_NULL_HANDLE) continue;
    garbage_.retire(frame_, texture.texture);
    garbage_.retire(frame_, texture.set.pool);
    charged_bytes_ -= texture.charged_bytes;
  }
  plant = {};
}

void Renderer::drop_page(std::uint32_t plant, std::uint32_t page) {
  std::uint32_t& slot = plants_[plant].page_slots[page];
  if (slot == PagePool::kNoSlot) return;
  pages_.free(device_, slot);
  slot = PagePool::kNoSlot;
  charged_bytes_ -= kPageBytes;
}

void Renderer::drop_mesh(MeshBuffer& mesh) {
  if (mesh.buffer.buffer == VK_NULL_HANDLE) return;
  destroy_buffer(device_, mesh.buffer);
  charged_bytes_ -= mesh.charged_bytes;
  mesh = {};
}

void Renderer::drop_wood(std::uint32_t plant, std::uint32_t lod) {
  drop_mesh(plants_[plant].wood[lod]);
  if (raster_) raster_->meshes().drop_mesh(plant, kWoodLists + lod, frame_);
}

void Renderer::drop_leaf_mesh(std::uint32_t plant, std::uint32_t index) {
  drop_mesh(plants_[plant].leaf_meshes[index]);
  if (raster_) raster_->meshes().drop_mesh(plant, kMeshLists + index, frame_);
}

void Renderer::hide_texture(std::uint32_t plant, std::uint32_t texture) {
  plants_[plant].textures[texture].visible = false;
}

void Renderer::drop_texture(std::uint32_t plant, std::uint32_t texture) {
  PlantTexture& dropped = plants_[plant].textures[texture];
  if (dropped.texture.image == VK_NULL_HANDLE) return;
  destroy_texture(device_, dropped.texture);
  device_.vk.vkDestroyDescriptorPool(device_.device, dropped.set.pool, nullptr);
  charged_bytes_ -= dropped.charged_bytes;
  dropped = {};
}

// The pool's share is its slack, and never less than a block: if it dropped to what is allocated now, the page that takes the last free
// slot would cost a block more than what was reserved for it, and be evicted for that in the next frame, again and again.
std::uint64_t Renderer::overhead_bytes() const {
  const std::uint64_t unaccounted = device_.allocated_bytes - std::min(device_.allocated_bytes, charged_bytes_);
  const std::uint64_t lists_bytes = raster_ ? raster_->meshes().bytes() : 0;
  return unaccounted + lists_bytes + pages_.block_bytes() - std::min(pages_.slack_bytes(), pages_.block_bytes());
}

// A larger budget has larger blocks of pages.
std::uint64_t Renderer::least_budget_bytes(std::uint64_t taken_bytes) const {
  const std::uint64_t without_block = taken_bytes - pages_.block_bytes();
  std::uint64_t least = 0;
  for (std::uint64_t next = taken_bytes; next != least; next = without_block + pool_block_pages(least) * kPageBytes) least = next;
  return least;
}

void Renderer::set_room(std::uint64_t bytes) {
  const std::uint64_t now = overhead_bytes();
  most_overhead_bytes_ = bytes < ~now ? now + bytes : ~std::uint64_t{0};
}

std::uint64_t Renderer::room_bytes() const {
  return most_overhead_bytes_ - std::min(most_overhead_bytes_, overhead_bytes());
}

std::uint64_t Renderer::upload_room_bytes() const {
  const std::uint64_t ring = staging_.room_bytes();
  return ring - std::min(ring, kFrameStagingBytes);
}

bool Renderer::has_room(std::uint64_t bytes, const WoodMesh* wood) {
  if (bytes <= kStagingSliceBytes && bytes > upload_room_bytes()) return false;
  const std::uint64_t wanted = kSmallBytes + (wood != nullptr && raster_ ? MeshLists::mesh_bytes(*wood) : 0);
  const bool fits = wanted <= room_bytes();
  if (!fits) lacking_bytes_ = std::max(lacking_bytes_, wanted);
  return fits;
}

std::uint64_t Renderer::growth_bytes(std::uint64_t instance_count) const {
  const std::uint64_t commands = instance_count * sizeof(DrawCommand);
  const std::uint64_t places = instance_count * (kMaxWoodLods + 1) * sizeof(std::uint32_t);
  return (commands > leaf_commands_.size_bytes ? with_margin(commands) : 0) + (places > wood_list_.size_bytes ? with_margin(places) : 0);
}

std::uint64_t Renderer::needed_room_bytes(const InstanceTable& instances, std::uint64_t added) const {
  const std::uint64_t slots = instances.slots().size() + added;
  const std::uint64_t new_slots = slots - std::min<std::uint64_t>(slots, instance_slot_count_);
  const bool staged = new_slots * sizeof(Instance) > kFrameStagingBytes;
  return growth_bytes(instances.count() + added) + (staged ? new_slots * (sizeof(Instance) + sizeof(InstanceBlock)) : 0);
}

std::uint64_t Renderer::wanted_room_bytes(const InstanceTable& instances, const coppice_view& view) const {
  std::uint64_t wanted = kSmallBytes + needed_room_bytes(instances, 0);
  std::uint64_t lists = lacking_bytes_;
  if (raster_) {
    wanted += raster_->wanted_bytes(view);
    lists = std::max(lists, std::min(raster_->meshes().wanted_bytes(), desc_.memory_budget_bytes / kListShare));
  }
  return wanted + lists;
}

}  // namespace coppice::gpu
