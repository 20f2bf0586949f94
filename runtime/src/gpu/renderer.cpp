#include "renderer.h"

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "check.h"

namespace coppice::gpu {
namespace {

/// Bytes of the staging ring kept free for instances, tables and lists.
constexpr std::uint64_t kFrameStagingBytes = 1ull << 19;
/// A block of device memory is the budget divided by this. So few of the 4,096 allocations that devices guarantee are needed.
constexpr std::uint64_t kBlockShare = 32;
/// Capacity at the beginning.
constexpr std::uint32_t kFirstPlants = 16;

constexpr VkPipelineStageFlags2 kReadStages = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
                                              VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT |
                                              VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT;
constexpr VkAccessFlags2 kReads = VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_INDEX_READ_BIT |
                                  VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT;

std::uint64_t block_bytes(std::uint64_t budget_bytes) {
  return std::clamp(budget_bytes / kBlockShare, DeviceMemory::kMinBlockBytes, DeviceMemory::kMaxBlockBytes);
}

/// Number of clusters in the rasteriser's lists, which take the same share of every budget up to 256 MiB.
std::uint32_t work_clusters(std::uint64_t budget_bytes) {
  constexpr std::uint64_t kBytesPerCluster = (256ull << 20) / kWorkClusters, kMinClusters = 1u << 14;
  return static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(budget_bytes / kBytesPerCluster / kMinClusters * kMinClusters, kMinClusters, kWorkClusters));
}

Capacity at_least(const Capacity& a, const Capacity& b) {
  return {std::max(a.slots, b.slots), std::max(a.plants, b.plants), b.clusters};
}

}  // namespace

Renderer::Renderer(const RendererDesc& desc)
    : device_(desc.device),
      memory_(device_),
      desc_(desc),
      pipelines_(device_, desc.pipeline_cache, desc.blocking_pipelines ? coppice_jobs{} : desc.jobs),
      deletion_(device_),
      uploads_(device_, deletion_, desc.allocator),
      growing_(device_),
      triangles_(device_, pipelines_),
      texture_sets_(device_),
      plants_(device_, deletion_, uploads_, texture_sets_, desc.allocator),
      wind_maps_(device_, desc.allocator),
      views_(device_, deletion_, pipelines_, scene_, plants_, desc.allocator) {
  if (!desc.only_measured) return;
  device_.vk = without_memory(device_.vk);
  device_.memory.hook = {};
}

Result<std::unique_ptr<Renderer>> Renderer::create(const RendererDesc& desc) {
  std::unique_ptr<Renderer> renderer(new (std::nothrow) Renderer(desc));
  if (!renderer) return Error{Status::out_of_memory, "renderer"};
  COPPICE_CHECK(renderer->create());
  return renderer;
}

Result<void> Renderer::create() {
  lower_limits();
  COPPICE_CHECK(texture_sets_.create());
  COPPICE_CHECK(uploads_.create());
  COPPICE_CHECK(plants_.create());
  COPPICE_CHECK(views_.create(desc_.views, texture_sets_));
  COPPICE_CHECK(triangles_.create());
  if (desc_.views.pass_times) COPPICE_CHECK(timer_.create(device_));
  COPPICE_CHECK(create_buffers());
  // Blocks are small up to here, so the memory before any plant does not depend on the budget.
  set_memory_budget(desc_.memory_budget_bytes);
  return device_state();
}

Renderer::~Renderer() {
  pipelines_.close();
  timer_.destroy(device_);
  for (Buffer* buffer : {&scene_.instances, &scene_.moved, &scene_.plants, &scene_.tables, &scene_.quad_indices, &scene_.wind_maps})
    destroy_buffer(device_, *buffer);
}

// Lowers limits to what the device binds, culls in one dispatch and draws in one call.
void Renderer::lower_limits() {
  const auto lower = [](std::uint32_t& limit, std::uint64_t maximum) {
    limit = static_cast<std::uint32_t>(std::min<std::uint64_t>(limit, maximum));
  };
  lower(desc_.views.max_instances, std::uint64_t{device_.max_group_count} * kCullGroupSize);
  lower(desc_.views.max_instances, device_.max_draw_count);
  lower(desc_.max_plants, device_.max_storage_bytes / (kMeshCommands * sizeof(DrawCommand)));
  if (device_.reads_texels) lower(desc_.views.max_instances, device_.max_texel_count / (sizeof(Instance) / sizeof(vec4)));
}

BufferSizes Renderer::sizes(const Capacity& capacity) {
  constexpr VkBufferUsageFlags kTexels = VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  constexpr VkBufferUsageFlags kTo = VK_BUFFER_USAGE_TRANSFER_DST_BIT, kFrom = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  const std::uint64_t slots = std::max(capacity.slots, std::min(kFirstSlots, desc_.views.max_instances)), plants = capacity.plants;
  BufferSizes sizes;
  sizes.add({&scene_.instances, "coppice instances", slots * sizeof(Instance), kTexels | kTo | kFrom, true, VK_FORMAT_R32G32B32A32_UINT});
  sizes.add({&scene_.moved, "coppice moved instances", InstanceTable::max_moved(static_cast<std::uint32_t>(slots)) * sizeof(Instance),
             kTexels | kTo, false, VK_FORMAT_R32G32B32A32_UINT});
  sizes.add({&scene_.plants, "coppice plant records", plants * sizeof(Plant), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | kTo});
  sizes.add({&scene_.tables, "coppice tables", plants * kTableStride * sizeof(std::uint32_t), kTexels | kTo | kFrom, true});
  sizes.add({&scene_.wind_maps, "coppice wind maps", (has_wind_maps_ ? kWindMaps * kMaxMapPlaces : 1) * sizeof(vec2), kTexels | kTo, false,
             VK_FORMAT_R32G32_UINT});
  views_.add_sizes(capacity, sizes);
  return sizes;
}

Result<void> Renderer::create_buffers() {
  capacity_.plants = std::min(kFirstPlants, desc_.max_plants);
  BufferSizes first = sizes(capacity_);
  first.add({&scene_.quad_indices, "coppice quad indices", std::uint64_t{kClusterLeaves} * 6 * sizeof(std::uint16_t),
             VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT});
  for (const BufferSize& size : first.span())
    if (size.bytes > 0) COPPICE_CHECK(move_into(*size.buffer, create_buffer(device_, size.desc(MemoryKind::lasting))));
  COPPICE_CHECK(plants_.reserve(capacity_.plants));
  return views_.reserve_plants(capacity_.plants);
}

std::uint64_t Renderer::reserve_bytes(const Capacity& needed) {
  const Capacity capacity = at_least(needed, capacity_);
  return capacity == capacity_ ? 0 : growing_.reserve_bytes(sizes(capacity));
}

Result<void> Renderer::reserve(const Capacity& needed) {
  COPPICE_ASSERT(needed.slots <= desc_.views.max_instances && needed.plants <= desc_.max_plants);
  COPPICE_CHECK(plants_.reserve(needed.plants));
  COPPICE_CHECK(views_.reserve_plants(needed.plants));
  const Capacity capacity = at_least(needed, capacity_);
  if (capacity == capacity_) return {};
  COPPICE_CHECK(growing_.reserve(sizes(capacity)));
  capacity_ = capacity;
  return {};
}

bool Renderer::shrink(std::uint32_t slots) {
  Capacity capacity = capacity_;
  capacity.slots = std::min(capacity.slots, slots);
  if (!growing_.shrink(sizes(capacity))) return false;
  capacity_ = capacity;
  return true;
}

std::uint64_t Renderer::picture_bytes(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t eye_count) const {
  const PictureSize size = picture_size(width_px, height_px, eye_count);
  return has_raster() ? size.picture_bytes + size.tile_bytes : 0;
}

std::uint64_t Renderer::lasting_bytes(std::uint32_t slots, std::uint64_t budget_bytes) {
  const BufferSizes needed = sizes({slots, capacity_.plants, work_clusters(budget_bytes)});
  const std::uint64_t now = gpu::lasting_bytes(device_.memory, block_bytes(budget_bytes)) - deletion_.bytes();
  if (slots > capacity_.slots) return now + growing_.reserve_bytes(needed) + views_.max_command_bytes(budget_bytes);
  return now - growing_.excess_bytes(needed) - views_.picture_bytes();
}

void Renderer::begin_wind_map(FrameWind& wind) {
  Result<void> result;
  if (wind.now.wind.map != nullptr && !has_wind_maps_) {
    has_wind_maps_ = true;
    const BufferSizes needed = sizes(capacity_);
    if (fits_buffer(device_, growing_.reserve_bytes(needed)))
      result = growing_.reserve(needed);
    else
      result = Error{Status::out_of_memory, "the memory budget has no room for maps"};
    has_wind_maps_ = static_cast<bool>(result);
    if (!result) wind.now.wind.map = nullptr;
  }
  if (auto copied = wind_maps_.begin_frame(wind); !copied) result = copied;
  if (!result) go_on_without(device_, result.error(), "plants move without the wind's map");
}

Result<void> Renderer::add_plant(std::uint32_t index, const PlantFile& file, const PlantAppearance& appearance,
                                 std::span<const std::uint32_t> lod_words) {
  COPPICE_ASSERT(index < desc_.max_plants);
  COPPICE_CHECK(reserve({.plants = index + 1}));
  COPPICE_CHECK(plants_.add(index, file, appearance, lod_words));
  if (plants_.plant(index)->has_cuts) views_.request_leaves(index);
  return {};
}

void Renderer::begin_frame(std::uint64_t frame_number, std::uint64_t completed_number) {
  frame_ = frame_number;
  completed_ = completed_number;
  upload_state_ = UploadState::none;
  pipelines_.collect();
  if (lists_may_grow_) {
    const BufferSizes needed = sizes(capacity_);
    lists_may_grow_ = !fits_buffer(device_, growing_.reserve_bytes(needed)) || !growing_.reserve(needed);
  }
  deletion_.begin_frame(frame_number, completed_number);
  uploads_.begin_frame(frame_number, completed_number);
  views_.begin_frame(frame_number, completed_number);
  if (timer_.exists()) timer_.collect(device_, completed_number);
}

void Renderer::record_upload_begin(VkCommandBuffer cmd) {
  upload_cmd_ = cmd;
  upload_state_ = UploadState::recording;
  if (std::exchange(gives_pictures_back_, false)) views_.release_pictures();
  if (growing_.replace(uploads_, deletion_)) views_.buffers_changed();
}

Result<void> Renderer::upload_page(const PageUpload& upload) {
  COPPICE_CHECK(plants_.upload_page(upload));
  if (upload.page == 0 || plants_.plant(upload.plant)->has_transparency) views_.request_leaves(upload.plant);
  return {};
}

Result<bool> Renderer::upload_mesh(const MeshUpload& upload, std::uint64_t max_bytes) {
  COPPICE_TRY(whole, plants_.upload_mesh(upload, max_bytes));
  if (whole) views_.request_mesh(upload.plant, upload.mesh);
  return whole;
}

Result<void> Renderer::stage_indices() {
  if (has_indices_) return {};
  constexpr std::uint16_t kQuad[6] = {0, 1, 2, 0, 2, 3};
  std::array<std::uint16_t, std::size_t{kClusterLeaves} * 6> indices{};
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint16_t>(i / 6 * 4 + kQuad[i % 6]);
  COPPICE_CHECK(uploads_.copy(bytes_of(std::span<const std::uint16_t>(indices)), scene_.quad_indices, 0));
  has_indices_ = true;
  return {};
}

Result<void> Renderer::stage_instances(InstanceTable& instances) {
  const std::span<const Instance> slots = instances.slots();
  COPPICE_ASSERT(slots.size() <= capacity_.slots);
  instances.update_bounds();
  const auto stage = [&](const SlotRange& range) -> Result<void> {
    COPPICE_CHECK(uploads_.copy(bytes_of(slots.subspan(range.first, range.count)), scene_.instances, range.first * sizeof(Instance)));
    const Buffer* blocks = views_.block_buffer();
    if (blocks == nullptr) return {};
    static_assert(kDirtyBlockSlots % kBlockSlots == 0);
    const auto bounds = instances.blocks().bounds.subspan(range.first / kBlockSlots, (range.count + kBlockSlots - 1) / kBlockSlots);
    COPPICE_TRY(data, uploads_.copy(bounds.size() * sizeof(InstanceBlock), *blocks, range.first / kBlockSlots * sizeof(InstanceBlock)));
    std::ranges::transform(bounds, reinterpret_cast<InstanceBlock*>(data), gpu_block);
    return {};
  };
  for (SlotRange range = instances.take_dirty(); range.count > 0; range = instances.take_dirty()) {
    if (auto staged = stage(range); !staged) {
      instances.mark_dirty(range);
      return staged;
    }
  }
  if (!instances.moved().empty()) COPPICE_CHECK(uploads_.copy(bytes_of(instances.moved()), scene_.moved, 0));
  uploaded_slot_count_ = static_cast<std::uint32_t>(slots.size());
  return {};
}

Result<void> Renderer::stage_frame(InstanceTable& instances, std::span<const LodPlant> plants) {
  COPPICE_CHECK(stage_indices());
  COPPICE_CHECK(plants_.upload_tables(scene_.tables));
  COPPICE_CHECK(wind_maps_.upload(uploads_, scene_.wind_maps));
  COPPICE_CHECK(stage_instances(instances));
  COPPICE_CHECK(views_.prepare(instances, plants, desc_.memory_budget_bytes));
  instances.forget_moves();
  return {};
}

Result<void> Renderer::record_upload_end(InstanceTable& instances, std::span<const LodPlant> plants) {
  COPPICE_ASSERT(upload_state_ == UploadState::recording && plants.size() >= plants_.count());
  auto staged = stage_frame(instances, plants);
  if (timer_.exists()) timer_.begin(device_, upload_cmd_, frame_, completed_);
  memory_barrier(device_, upload_cmd_, kReadStages | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                 VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT);
  uploads_.record(upload_cmd_);
  update_buffer(device_, upload_cmd_, scene_.plants, bytes_of(views_.plant_records()));
  memory_barrier(device_, upload_cmd_, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, kReadStages, kReads);
  if (timer_.exists()) timer_.mark(device_, upload_cmd_, Pass::upload);
  upload_cmd_ = VK_NULL_HANDLE;
  upload_state_ = staged ? UploadState::uploaded : UploadState::failed;
  return staged;
}

Result<std::uint32_t> Renderer::add_view(const AttachmentDesc& attachments) {
  COPPICE_TRY(view, views_.add(attachments, capacity_));
  // The first view of its kind may need lists that views share.
  if (auto shared = growing_.reserve(sizes(capacity_)); !shared) {
    remove_view(view);
    return shared.error();
  }
  return view;
}

void Renderer::remove_view(std::uint32_t view) {
  BufferSizes sizes;
  views_.view(view).add_sizes({}, sizes);
  growing_.forget(sizes);
  views_.remove(view);
}

void Renderer::set_memory_budget(std::uint64_t bytes) {
  lists_may_grow_ = true;
  desc_.memory_budget_bytes = bytes;
  capacity_.clusters = work_clusters(bytes);
  set_block_bytes(device_, block_bytes(bytes), kPageBytes);
}

std::uint64_t Renderer::staging_bytes() const {
  const std::uint64_t ring = uploads_.room_bytes();
  return ring - std::min(ring, kFrameStagingBytes);
}

std::uint64_t Renderer::slot_upload_bytes(std::uint32_t slot_count) const {
  const std::uint64_t new_slots = slot_count - std::min(slot_count, uploaded_slot_count_);
  return new_slots * sizeof(Instance) > kFrameStagingBytes ? new_slots * (sizeof(Instance) + sizeof(InstanceBlock)) : 0;
}

}  // namespace coppice::gpu
