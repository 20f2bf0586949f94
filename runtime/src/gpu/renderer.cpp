#include "renderer.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <new>
#include <utility>

#include "check.h"
#include "convert.h"
#include "leaf_entry.h"
#include "page_codec.h"

namespace coppice::gpu {
namespace {

constexpr std::uint64_t kStagingBytes = 8ull << 20;
/// Kept free in the staging ring for what is no chunk: instances, tables, lists.
constexpr std::uint64_t kFrameStagingBytes = 1ull << 19;
/// A block of device memory is one part in this many of the budget: of 4,096 allocations that devices promise, few are taken.
constexpr std::uint64_t kBlockShare = 32;
/// That there is room for from the beginning.
constexpr std::uint32_t kFirstPlants = 16;

std::uint64_t block_bytes(std::uint64_t budget_bytes) {
  return std::clamp(budget_bytes / kBlockShare, DeviceMemory::kLeastBlockBytes, DeviceMemory::kMostBlockBytes);
}

void add_distinct(std::vector<std::uint32_t>& values, std::uint32_t value) {
  if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
}

/// What is taken of the device for a buffer may be so much more than its bytes.
constexpr std::uint64_t kBufferRounding = 4096;

}  // namespace

Renderer::Renderer(const RendererDesc& desc)
    : device_(desc.device), desc_(desc), pipelines_(device_, desc.pipeline_cache, desc.blocking_pipelines ? coppice_jobs{} : desc.jobs) {
  if (!desc.only_measured) return;
  device_.vk = without_memory(device_.vk);
  device_.memory.hook = {};
}

Result<std::unique_ptr<Renderer>> Renderer::create(const RendererDesc& desc) {
  std::unique_ptr<Renderer> renderer(new (std::nothrow) Renderer(desc));
  if (!renderer) return Error{Status::out_of_memory, "renderer"};
  renderer->lower_limits();
  COPPICE_CHECK(create_passes(renderer->device_, desc.attachments, renderer->pipelines_, renderer->passes_));
  COPPICE_TRY(staging, Staging::create(renderer->device_, kStagingBytes));
  renderer->staging_ = std::move(staging);
  COPPICE_CHECK(renderer->create_default_texture());
  COPPICE_CHECK(renderer->create_buffers());
  if (desc.pass_times) COPPICE_CHECK(renderer->timer_.create(renderer->device_));
  COPPICE_CHECK(renderer->create_raster());
  // Until here blocks are small, whatever the budget: what is taken before any plant does not depend on it.
  renderer->set_memory_budget(desc.memory_budget_bytes);
  if (desc.only_measured) return renderer;
  // What nearly every plant needs; the rest when it is first met.
  DrawPipelines& camera = renderer->passes_.camera;
  for (Pipeline* pipeline : {renderer->passes_.cull[0], camera.leaf[1], camera.wood.plain[1]}) renderer->pipelines_.want(*pipeline);
  (void)renderer->want(coppice_view{});
  COPPICE_CHECK(renderer->device_state());
  return renderer;
}

Result<void> Renderer::create_raster() {
  if (!desc_.compute_raster) return {};
  auto raster = LeafRaster::create(device_, garbage_, pipelines_,
                                   {.attachments = desc_.attachments,
                                    .frame_set_layout = passes_.frame_set_layout,
                                    .max_instances = desc_.max_instances,
                                    .int64_atomics = desc_.int64_atomics,
                                    .many_lanes = desc_.many_lanes});
  if (raster)
    raster_ = *std::move(raster);
  else if (raster.error().status == Status::unsupported)
    go_on_without(device_, raster.error(), "all plants are drawn by the hardware");
  else
    return raster.error();
  return {};
}

void Renderer::set_memory_budget(std::uint64_t bytes) {
  desc_.memory_budget_bytes = bytes;
  set_block_bytes(device_, block_bytes(bytes), kPageBytes);
}

Renderer::~Renderer() {
  pipelines_.close();
  garbage_.collect(device_, ~std::uint64_t{0});
  for (PlantSlot& plant : plants_)
    if (plant.used) destroy_plant(plant);
  for (LargerBuffer& larger : larger_) destroy_buffer(device_, larger.buffer);
  raster_.reset();
  timer_.destroy(device_);
  garbage_.collect(device_, ~std::uint64_t{0});
  staging_.destroy(device_);
  for (Buffer* buffer :
       {&fixed_.view, &fixed_.counters, &fixed_.indices, &fixed_.readback, &growing_.instances, &growing_.cuts, &growing_.debug_colors,
        &growing_.plants, &growing_.tables, &growing_.draw_counts, &growing_.wood_commands, &leaf_commands_, &wood_list_})
    if (buffer->buffer != VK_NULL_HANDLE) destroy_buffer(device_, *buffer);
  if (default_texture_.image != VK_NULL_HANDLE) destroy_texture(device_, default_texture_);
  device_.vk.vkDestroyDescriptorPool(device_.device, frame_set_.pool, nullptr);
  device_.vk.vkDestroyDescriptorPool(device_.device, shadowed_set_.pool, nullptr);
  device_.vk.vkDestroyDescriptorPool(device_.device, default_set_.pool, nullptr);
  destroy_passes(device_, passes_);
  close_memory(device_);
}

// What the device binds, and what it culls in one dispatch.
void Renderer::lower_limits() {
  const auto lower = [](std::uint32_t& limit, std::uint64_t most) {
    limit = static_cast<std::uint32_t>(std::min<std::uint64_t>(limit, most));
  };
  lower(desc_.max_instances, std::uint64_t{device_.max_group_count} * kCullGroupSize);
  lower(desc_.max_instances, device_.max_storage_bytes / sizeof(Instance));
  lower(desc_.max_plants, device_.max_storage_bytes / (kMeshCommands * sizeof(DrawCommand)));
  lower(desc_.max_plants, device_.max_texel_count / kTableStride);
}

std::vector<BufferSize> Renderer::sizes(const Capacity& capacity) {
  constexpr VkBufferUsageFlags kFrom = VK_BUFFER_USAGE_TRANSFER_SRC_BIT, kIndirect = VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
  const std::uint64_t slots = capacity.slots, plants = capacity.plants;
  std::vector<BufferSize> sizes{
      {&growing_.instances, slots * sizeof(Instance), kStorage | kFrom, true},
      {&growing_.cuts, slots * sizeof(float), kStorage | kFrom},
      {&growing_.debug_colors, slots * sizeof(std::uint32_t), kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT},
      {&wood_list_, slots * most_mesh_lists_ * sizeof(std::uint32_t), kStorage},
      {&leaf_commands_, slots * sizeof(DrawCommand), kStorage | kIndirect},
      {&growing_.plants, plants * sizeof(Plant), kStorage},
      {&growing_.tables, plants * kTableStride * sizeof(std::uint32_t),
       VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | kFrom, true},
      {&growing_.draw_counts, kDrawCounts * plants * sizeof(std::uint32_t), kStorage | kIndirect},
      {&growing_.wood_commands, plants * kMeshCommands * sizeof(DrawCommand), kStorage | kIndirect}};
  if (raster_) std::ranges::copy(raster_->sizes(capacity.slots), std::back_inserter(sizes));
  return sizes;
}

Result<void> Renderer::create_buffers() {
  std::vector<BufferSize> wanted{{&fixed_.view, sizeof(View), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT},
                                 {&fixed_.counters, sizeof(Counters), kStorage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT},
                                 {&fixed_.indices, std::uint64_t{kClusterLeaves} * 6 * sizeof(std::uint16_t),
                                  VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT}};
  // Without the rasteriser's lists, which are large: before the first instance nothing needs them.
  capacity_.plants = std::min(kFirstPlants, desc_.max_plants);
  std::ranges::copy(sizes({std::min(kFirstSlots, desc_.max_instances), capacity_.plants}), std::back_inserter(wanted));
  for (const BufferSize& item : wanted) {
    COPPICE_TRY(buffer, create_buffer(device_, item.bytes, item.usage, MemoryKind::device));
    *item.buffer = buffer;
  }
  COPPICE_TRY(readback, create_buffer(device_, kReadbackSlots * sizeof(Counters), VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryKind::host));
  fixed_.readback = readback;
  return rebuild_frame_set();
}

std::vector<BufferSize> Renderer::growing(const Capacity& wanted) {
  std::vector<BufferSize> growing = sizes({std::max(wanted.slots, capacity_.slots), std::max(wanted.plants, capacity_.plants)});
  std::erase_if(growing, [&](const BufferSize& size) {
    const auto larger = std::ranges::find(larger_, size.buffer, &LargerBuffer::smaller);
    return size.bytes <= (larger != larger_.end() ? larger->buffer : *size.buffer).size_bytes;
  });
  return growing;
}

std::uint64_t Renderer::reserve_bytes(const Capacity& wanted) {
  constexpr std::uint64_t kRounding = 1024;  // of a request, at most
  std::uint64_t bytes = 0;
  for (const BufferSize& size : growing(wanted)) bytes += size.bytes + kRounding;
  return bytes;
}

Result<void> Renderer::reserve(const Capacity& wanted) {
  COPPICE_ASSERT(wanted.slots <= desc_.max_instances && wanted.plants <= desc_.max_plants);
  std::vector<LargerBuffer> larger;
  for (const BufferSize& size : growing(wanted)) {
    auto buffer = create_buffer(device_, size.bytes, size.usage, MemoryKind::alone);
    if (!buffer) {
      for (LargerBuffer& made : larger) destroy_buffer(device_, made.buffer);
      return buffer.error();
    }
    larger.push_back({size.buffer, *buffer, size.kept});
  }
  // What was to take over has not been seen by the GPU.
  for (const LargerBuffer& next : larger) {
    const auto before = std::ranges::find(larger_, next.smaller, &LargerBuffer::smaller);
    if (before == larger_.end()) {
      larger_.push_back(next);
    } else {
      destroy_buffer(device_, before->buffer);
      *before = next;
    }
  }
  capacity_ = {std::max(wanted.slots, capacity_.slots), std::max(wanted.plants, capacity_.plants)};
  return {};
}

void Renderer::take_larger() {
  for (const LargerBuffer& larger : larger_) {
    Buffer& smaller = *larger.smaller;
    if (larger.kept && smaller.buffer != VK_NULL_HANDLE)
      moves_.push_back({smaller.buffer, larger.buffer.buffer, {0, 0, smaller.size_bytes}});
    if (smaller.buffer != VK_NULL_HANDLE) garbage_.retire(frame_, smaller);
    smaller = larger.buffer;
  }
  if (larger_.empty()) return;
  frame_set_stale_ = true;
  if (raster_) raster_->buffers_changed();
  larger_.clear();
}

Result<void> Renderer::create_default_texture() {
  COPPICE_TRY(texture, create_texture(device_, {1, 1, 1, COPPICE_TEXTURE_RGBA8}));
  default_texture_ = texture;
  COPPICE_TRY(set, create_texture_set(device_, passes_, texture.view));
  default_set_ = set;
  return {};
}

FrameBindings Renderer::frame_bindings() const {
  FrameBindings bindings{.buffers = {&fixed_.view, &growing_.instances, &growing_.plants, &growing_.tables, &growing_.cuts, &wood_list_,
                                     &leaf_commands_, &growing_.draw_counts, &growing_.wood_commands, &fixed_.counters}};
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
  pipelines_.collect();
  drawable_ = false;
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

Result<void> Renderer::add_plant(std::uint32_t index, const PlantFile& file, const PlantAppearance& appearance,
                                 std::span<const std::uint32_t> lod_words) {
  COPPICE_ASSERT(index < desc_.max_plants && lod_words.size() <= kTableStride);
  most_mesh_lists_ = std::max(most_mesh_lists_, file.plant.wood_lod_count + (file.plant.leaf_mesh_count > 0 ? 1 : 0));
  COPPICE_CHECK(reserve({.plants = index + 1}));
  if (index >= plants_.size()) {
    plants_.resize(index + 1);
    records_.resize(index + 1);
    plant_counts_.resize(index + 1);
    mesh_templates_.resize(std::size_t{index + 1} * kMeshCommands);
  }
  PlantSlot& plant = plants_[index];
  COPPICE_ASSERT(!plant.used);
  plant = {};
  plant.layout = place_plant_tables(file);
  COPPICE_TRY(tables, create_buffer(device_, plant.layout.bytes, kStorage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT, MemoryKind::device));
  plant.used = true;
  plant.tables = tables;
  plant.record = gpu_plant(file.plant);
  plant.record.cards = gpu_address(tables.address + plant.layout.cards_at);
  plant.record.materials = gpu_address(tables.address + plant.layout.materials_at);
  plant.record.card_looks = gpu_address(tables.address + plant.layout.looks_at);
  plant.record.crown_light = gpu_address(tables.address + plant.layout.crown_at);
  plant.record.lists = gpu_address(tables.address + plant.layout.lists_at);
  plant.pages.resize(file.plant.page_count);
  plant.textures.resize(file.plant.texture_count);
  plant.leaf_mesh_count = file.plant.leaf_mesh_count;

  plant.pending_tables.resize(plant.layout.bytes);
  const auto fill = [&](std::uint64_t at, const auto& values) {
    if (!values.empty()) std::memcpy(plant.pending_tables.data() + at, values.data(), values.size() * sizeof values[0]);
  };
  fill(plant.layout.looks_at, appearance.looks.looks);
  fill(plant.layout.crown_at, appearance.light.words);
  std::vector<Card> cards;
  for (const coppice_file_card& card : file.cards) {
    cards.push_back(gpu_card(card));
    add_distinct(plant.leaf_textures, gpu_material(file.materials[card.material]).texture);
  }
  fill(plant.layout.cards_at, cards);
  std::vector<Material> materials;
  for (const coppice_file_material& material : file.materials) {
    materials.push_back(gpu_material(material));
    plant.material_textures.push_back({materials.back().texture, materials.back().normal_map});
  }
  fill(plant.layout.materials_at, materials);
  // A page or list that is not there points at something readable: a shader may load from it before it finds that it need not.
  fill(plant.layout.pages_at, std::vector<uvec2>(std::max<std::size_t>(file.plant.page_count, 1), gpu_address(tables.address)));
  std::vector<ClusterList> lists(kClusterLists, empty_list(leaf_box(plant.record)));
  for (ClusterList& list : lists) {
    list.leaf_count = file.plant.leaf_count;
    list.blocks = gpu_address(tables.address);
  }
  lists[kPageList].blocks = gpu_address(tables.address + plant.layout.pages_at);
  fill(plant.layout.lists_at, lists);
  plant.pending_words.assign(lod_words.begin(), lod_words.end());
  auto added = file.plant.page_count == 0 ? add_single_leaf(plant, file, appearance) : Result<void>();
  if (!added) remove_plant(index);
  return added;
}

// A plant of one leaf has no pages: its cuts are made here.
Result<void> Renderer::add_single_leaf(PlantSlot& plant, const PlantFile& file, const PlantAppearance& appearance) {
  const auto scratch = std::make_unique<ClusterScratch>();
  ReadyCuts cuts;
  COPPICE_CHECK(allocate_into(cuts.bytes, default_allocator(), ready_cut_bytes(1)));
  build_ready_cuts({root_node(file.plant), appearance.looks.cards(), leaf_box(plant.record), &appearance.light, 1}, {}, *scratch, cuts);
  move_ready_cuts(1, cuts.lists, cuts.bytes.span(), plant.tables.address + plant.layout.cuts_at);
  std::memcpy(plant.pending_tables.data() + plant.layout.lists_at, cuts.lists.data(), sizeof cuts.lists);
  std::ranges::copy(cuts.bytes, plant.pending_tables.begin() + static_cast<std::ptrdiff_t>(plant.layout.cuts_at));
  plant.has_cuts = true;
  want_leaves(plant);
  return {};
}

void Renderer::remove_plant(std::uint32_t index) {
  COPPICE_ASSERT(plants_[index].used);
  destroy_plant(plants_[index]);
}

void Renderer::destroy_plant(PlantSlot& plant) {
  garbage_.retire(frame_, plant.tables);
  for (Buffer& page : plant.pages) drop_page(page);
  for (const MeshBuffer& mesh : plant.meshes) {
    if (mesh.buffer.buffer == VK_NULL_HANDLE) continue;
    garbage_.retire(frame_, mesh.buffer);
  }
  for (PlantTexture& texture : plant.textures) {
    if (texture.texture.image == VK_NULL_HANDLE) continue;
    garbage_.retire(frame_, texture.texture);
    garbage_.retire(frame_, texture.set.pool);
  }
  plant = {};
}

void Renderer::drop_page(std::uint32_t plant, std::uint32_t page) {
  drop_page(plants_[plant].pages[page]);
}

void Renderer::drop_page(Buffer& page) {
  if (page.buffer == VK_NULL_HANDLE) return;
  destroy_buffer(device_, page);
}

void Renderer::drop_mesh(std::uint32_t plant, std::uint32_t index) {
  MeshBuffer& mesh = plants_[plant].meshes[index];
  if (mesh.buffer.buffer == VK_NULL_HANDLE) return;
  destroy_buffer(device_, mesh.buffer);
  mesh = {};
}

void Renderer::hide_texture(std::uint32_t plant, std::uint32_t texture) {
  plants_[plant].textures[texture].visible = false;
}

void Renderer::drop_texture(std::uint32_t plant, std::uint32_t texture) {
  PlantTexture& dropped = plants_[plant].textures[texture];
  if (dropped.texture.image == VK_NULL_HANDLE) return;
  destroy_texture(device_, dropped.texture);
  device_.vk.vkDestroyDescriptorPool(device_.device, dropped.set.pool, nullptr);
  dropped = {};
}

// A larger budget has larger blocks.
std::uint64_t Renderer::least_budget_bytes(std::uint64_t taken_bytes) const {
  const std::uint64_t without_block = taken_bytes - committed_bytes(device_.memory);
  DeviceMemory memory = device_.memory;
  std::uint64_t least = 0;
  for (std::uint64_t next = taken_bytes; next != least; next = without_block + committed_bytes(memory)) {
    least = next;
    memory.block_bytes = whole_units(memory, block_bytes(least));
  }
  return least;
}

std::uint64_t Renderer::staging_bytes() const {
  const std::uint64_t ring = staging_.room_bytes();
  return ring - std::min(ring, kFrameStagingBytes);
}

std::uint64_t Renderer::slot_upload_bytes(std::uint32_t slot_count) const {
  const std::uint64_t new_slots = slot_count - std::min(slot_count, instance_slot_count_);
  return new_slots * sizeof(Instance) > kFrameStagingBytes ? new_slots * (sizeof(Instance) + sizeof(InstanceBlock)) : 0;
}

bool Renderer::fits(std::uint64_t bytes) {
  // A buffer takes a little more than it asks for.
  return bytes == 0 || device_.memory.ledger->fits(bytes + kBufferRounding);
}

}  // namespace coppice::gpu
