#include "context.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>
#include <utility>

#include "handle.h"

namespace coppice {
namespace {

/// The compute rasteriser's lists of a page's leaves and of the cuts coarser than it, about; see coppice_context_desc.compute_raster.
constexpr std::uint64_t kRasterListBytesPerTriangle = 60;

/// Plants that may be reloaded at a time.
constexpr std::uint32_t kReloadSlots = 4;
/// How long a reload waits for as much of the new file as is wanted.
constexpr std::uint64_t kReloadFrames = 120;

std::uint64_t nanoseconds(float ms) {
  return static_cast<std::uint64_t>(std::min(double{ms} * 1e6, 1e18));
}

/// A call from its beginning to its end.
class TraceScope {
 public:
  TraceScope(const coppice_trace& trace, coppice_trace_kind kind) : trace_(trace), kind_(kind), start_ns_(trace_start(trace)) {}
  TraceScope(const TraceScope&) = delete;
  TraceScope& operator=(const TraceScope&) = delete;
  ~TraceScope() { trace_end(trace_, {kind_, nullptr, nullptr, 0, 0, start_ns_, 0}); }

 private:
  const coppice_trace& trace_;
  coppice_trace_kind kind_;
  std::uint64_t start_ns_;
};

std::uint32_t index_of(coppice_plant plant) {
  return unpack_handle(plant).index;
}

/// The only thing that contexts of a process share: without it their handles could not be told apart.
std::uint32_t next_tag() {
  static std::atomic<std::uint32_t> created{0};
  return 1 + created.fetch_add(1, std::memory_order_relaxed) % ((1u << kHandleContextBits) - 1);
}

Result<std::unique_ptr<gpu::Renderer>> create_renderer(const coppice_context_desc& desc, const coppice_jobs& jobs) {
  COPPICE_TRY(device, gpu::open_device(desc.instance, desc.physical_device, desc.device, desc.get_instance_proc_addr));
  device.block_textures = desc.texture_compression_bc == VK_TRUE && gpu::has_block_textures(device);
  device.log = desc.log;
  const gpu::AttachmentDesc attachments{.color_format = desc.color_format,
                                        .depth_format = desc.depth_format,
                                        .depth_compare = desc.depth_compare,
                                        .samples = desc.samples,
                                        .shadow_format = desc.shadow_format};
  COPPICE_CHECK(gpu::check_attachments(device, attachments));
  return gpu::Renderer::create({.device = device,
                                .attachments = attachments,
                                .pipeline_cache = desc.pipeline_cache,
                                .memory_budget_bytes = desc.memory_budget_bytes,
                                .max_instances = desc.max_instances,
                                .max_plants = desc.max_plants + kReloadSlots,
                                .compute_raster = desc.compute_raster == VK_TRUE,
                                .int64_atomics = desc.shader_int64_atomics == VK_TRUE && gpu::has_int64_atomics(device),
                                .pass_times = desc.pass_times == VK_TRUE,
                                .jobs = jobs});
}

static_assert(COPPICE_STREAMED_PAGES == static_cast<int>(ChunkKind::page) && COPPICE_STREAMED_WOOD == static_cast<int>(ChunkKind::wood) &&
              COPPICE_STREAMED_TEXTURES == static_cast<int>(ChunkKind::texture) &&
              COPPICE_STREAMED_LEAF_MESHES == static_cast<int>(ChunkKind::leaf_mesh) && COPPICE_STREAMED_ALL == kChunkKindCount);

coppice_streamed_stats streamed_stats(const ChunkCounts& counts) {
  return {.loaded = counts.loaded,
          .evicted = counts.evicted,
          .failed = counts.failed,
          .cancelled = counts.cancelled,
          .in_flight = counts.in_flight,
          .wanted = counts.wanted,
          .queued = counts.queued};
}

}  // namespace

Result<std::unique_ptr<Context>> Context::create(const coppice_context_desc& desc) {
  std::unique_ptr<Context> context(new (std::nothrow) Context);
  if (!context) return Error{Status::out_of_memory, "context"};
  const std::uint32_t slot_count = desc.max_plants + kReloadSlots;
  context->tag_ = next_tag();
  COPPICE_TRY(hooks, complete_hooks({desc.allocator, desc.jobs, desc.io, desc.log, desc.trace}));
  context->hooks_ = std::move(hooks);
  COPPICE_TRY(renderer, create_renderer(desc, context->hooks_.hooks.jobs));
  context->renderer_ = std::move(renderer);
  COPPICE_TRY(instances, gpu::InstanceTable::create(context->hooks_.hooks.allocator, desc.max_instances, slot_count, context->tag_));
  context->instances_ = std::move(instances);
  const StreamerOptions options{.gpu = {.page_bytes = gpu::kPageBytes,
                                        .wood_vertex_bytes = sizeof(gpu::WoodVertex),
                                        .leaf_mesh_vertex_bytes = sizeof(gpu::LeafMeshVertex),
                                        .opening_bytes = gpu::Renderer::kSmallBytes,
                                        .wood_list_triangle_bytes = context->renderer_->has_raster() ? kRasterListBytesPerTriangle : 0,
                                        .most_staged_bytes = gpu::Renderer::kStagingSliceBytes,
                                        .block_textures = context->renderer_->block_textures()},
                                .budget_bytes = desc.memory_budget_bytes,
                                .max_plants = slot_count,
                                .hand_over_budget_ns = nanoseconds(desc.streaming_ms)};
  context->scene_plants_ = {desc.asset_root != nullptr ? desc.asset_root : "", desc.allow_outside == VK_TRUE, context->hooks_.real_files};
  context->max_instances_ = desc.max_instances;
  context->streaming_ns_ = options.hand_over_budget_ns;
  context->prefetch_frames_ = desc.prefetch_frames;
  COPPICE_TRY(streamer, Streamer::create(context->hooks_.hooks, options));
  context->streamer_ = std::move(streamer);
  context->max_plants_ = desc.max_plants;
  context->count_overhead();
  context->least_budget_bytes_ = context->renderer_->least_budget_bytes(context->streamer_->stats().memory_bytes);
  COPPICE_CHECK(context->check_budget(desc.memory_budget_bytes));
  return context;
}

Result<void> Context::check_budget(std::uint64_t bytes) const {
  if (bytes >= least_budget_bytes_) return {};
  constexpr double kMiB = 1 << 20;
  char detail[200];
  std::snprintf(detail, sizeof detail,
                "%.1f MiB is below the %.1f MiB (%llu bytes) that this context takes before any plant: raise it, or lower max_instances or "
                "max_plants",
                static_cast<double>(bytes) / kMiB, std::ceil(10 * static_cast<double>(least_budget_bytes_) / kMiB) / 10,
                static_cast<unsigned long long>(least_budget_bytes_));
  return Error{Status::invalid_argument, "memory budget", Error::kNoOffset, detail};
}

Result<void> Context::set_memory_budget(std::uint64_t bytes) {
  COPPICE_CHECK(check_budget(bytes));
  streamer_->set_memory_budget(bytes);
  return {};
}

const Context::PlantEntry& Context::entry(coppice_plant plant) const {
  return plants_[index_of(plant)];
}

Context::PlantEntry& Context::entry(coppice_plant plant) {
  return plants_[index_of(plant)];
}

Result<std::uint32_t> Context::open_slot(const char* path) {
  COPPICE_TRY(slot, streamer_->open_plant(path));
  if (const auto shown = show_slot(slot); !shown) {
    log_line(log(), COPPICE_LOG_ERROR, "%s: %s", path, shown.error().message().c_str());
    return shown.error();
  }
  return slot;
}

Result<void> Context::show_slot(std::uint32_t slot) {
  if (slot >= slots_.size()) {
    slots_.resize(slot + 1);
    demands_.resize(slot + 1);
    demand_ahead_.measured.resize(slot + 1);
    demand_ahead_.finished.resize(slot + 1);
    residency_.resize(slot + 1);
  }
  const PlantFile& file = streamer_->file(slot);
  if (auto added = renderer_->add_plant(slot, file, streamer_->lod_words(slot)); !added) {
    streamer_->close_plant(slot);
    return added.error();
  }
  instances_.set_plant_sphere(slot, file.plant.sphere_center, file.plant.sphere_radius);
  slots_[slot] = {.open = true, .on_gpu = true};
  count_overhead();
  return {};
}

void Context::close_slot(std::uint32_t slot) {
  instances_.remove_plant(slot);
  streamer_->close_plant(slot);
  forget_demand(demand_ahead_);
  slots_[slot].open = false;
}

Result<coppice_plant> Context::open_plant(const char* path) {
  if (free_entry() == max_plants_) {
    log_line(log(), COPPICE_LOG_ERROR, "%s: max_plants are open", path);
    return Error{Status::out_of_memory, "max_plants are open"};
  }
  COPPICE_TRY(slot, open_slot(path));
  return take_entry(slot);
}

std::uint32_t Context::free_entry() const {
  return static_cast<std::uint32_t>(std::ranges::find(plants_, false, &PlantEntry::open) - plants_.begin());
}

Result<coppice_plant> Context::take_entry(std::uint32_t slot) {
  const std::uint32_t index = free_entry();
  if (index == max_plants_) {
    close_slot(slot);
    return Error{Status::out_of_memory, "max_plants are open"};
  }
  if (index == plants_.size()) plants_.emplace_back();
  PlantEntry& entry = plants_[index];
  entry.open = true;
  entry.slot = slot;
  return pack_handle({HandleKind::plant, tag_, entry.generation, index});
}

bool Context::is_open(coppice_plant plant) const {
  const std::uint32_t index = index_of(plant);
  return index < plants_.size() && plants_[index].open && plant == pack_handle({HandleKind::plant, tag_, plants_[index].generation, index});
}

void Context::close_plant(coppice_plant plant) {
  PlantEntry& closing = entry(plant);
  close_slot(closing.slot);
  if (closing.next_slot != kNoSlot) close_slot(closing.next_slot);
  closing = {.generation = closing.generation + 1};
}

Result<void> Context::reload_plant(coppice_plant plant, const char* path) {
  PlantEntry& reloading = entry(plant);
  const std::string own_path = streamer_->path(reloading.slot);
  COPPICE_TRY(slot, open_slot(path != nullptr ? path : own_path.c_str()));
  if (reloading.next_slot != kNoSlot) close_slot(reloading.next_slot);
  reloading.next_slot = slot;
  reloading.swap_frame = frame_number_ + kReloadFrames;
  return {};
}

// What is pinned of the new file has to be there in any case: from then on it can be drawn.
void Context::finish_reloads() {
  for (PlantEntry& plant : plants_) {
    if (!plant.open || plant.next_slot == kNoSlot) continue;
    const PlantState state = streamer_->state(plant.next_slot);
    const coppice_file_plant& counts = streamer_->file(plant.next_slot).plant;
    const bool drawable =
        (counts.page_count == 0 || state.resident_page_count > 0) && (counts.wood_lod_count == 0 || state.resident_wood_mask != 0);
    if (!drawable || (!streamer_->is_settled(plant.next_slot) && frame_number_ < plant.swap_frame)) continue;
    instances_.replace_plant(plant.slot, plant.next_slot);
    close_slot(plant.slot);
    plant.slot = std::exchange(plant.next_slot, kNoSlot);
  }
}

void Context::fill_info(coppice_plant plant, coppice_plant_info& info) const {
  const std::uint32_t slot = entry(plant).slot;
  const PlantFile& file = streamer_->file(slot);
  const PlantState state = streamer_->state(slot);
  info.leaf_count = file.plant.leaf_count;
  info.resident_leaf_count = state.resident_leaf_count;
  info.page_count = file.plant.page_count;
  info.resident_page_count = state.resident_page_count;
  info.wood_lod_count = file.plant.wood_lod_count;
  info.wood_triangle_count = file.plant.wood_triangle_counts[0];
  std::copy_n(file.plant.sphere_center, 3, info.sphere_center);
  info.sphere_radius = file.plant.sphere_radius;
  const PlantBox& box = streamer_->box(slot);
  std::ranges::copy(box.low, info.box_min);
  std::ranges::copy(box.high, info.box_max);
  info.file_bytes = file.header.file_bytes;
  static_assert(sizeof info.name == sizeof file.plant.name);
  std::memcpy(info.name, file.plant.name, sizeof info.name);
}

Result<void> Context::add_instances(coppice_plant plant, std::span<const coppice_placement> placements,
                                    std::span<coppice_instance> handles) {
  // What draws them grows with them in the next frame: where it could not, nothing at all would be drawn.
  count_overhead();
  COPPICE_CHECK(streamer_->make_room(renderer_->needed_room_bytes(instances_, placements.size())));
  return instances_.add(entry(plant).slot, placements, handles);
}

void Context::count_overhead() {
  streamer_->set_overhead_bytes(renderer_->overhead_bytes() + instances_.bytes() + (scene_ ? scene_->bytes() : 0));
}

// Between frames, and while one is recorded, memory is taken for what the engine does: what is free is looked at when it is taken.
void Context::give_room() {
  count_overhead();
  renderer_->set_room(streamer_->free_bytes());
}

Result<void> Context::check_numbers(const coppice_frame& frame) const {
  const auto wrong = [](const char* what, std::uint64_t number, std::uint64_t other) {
    return Error{Status::invalid_argument, what, Error::kNoOffset, std::to_string(number) + " and " + std::to_string(other)};
  };
  if (frame.frame_number <= frame_number_)
    return wrong("frame.frame_number does not grow: it and the one before", frame.frame_number, frame_number_);
  if (frame.completed_number >= frame.frame_number)
    return wrong("frame.completed_number is not below frame.frame_number", frame.completed_number, frame.frame_number);
  if (frame.completed_number < completed_number_)
    return wrong("frame.completed_number falls: it and the one before", frame.completed_number, completed_number_);
  return {};
}

Result<void> Context::begin_frame(const coppice_frame& frame) {
  const TraceScope trace(hooks_.hooks.trace, COPPICE_TRACE_FRAME_BEGIN);
  COPPICE_CHECK(check_numbers(frame));
  COPPICE_TRY(view, demand_view(*frame.view));
  frame_number_ = frame.frame_number;
  completed_number_ = frame.completed_number;
  recording_ = Recording::begun;
  renderer_->begin_frame(frame.frame_number, frame.completed_number);
  const gpu::FrameCounts& counts = renderer_->counts();
  leaf_budget_.observe({counts.frame, counts.leaves, counts.wood_triangles, counts.hardware_triangles});
  threshold_px_ =
      leaf_budget_.threshold_px(frame.frame_number, view.lod.error_px, frame.view->lod == COPPICE_LOD_CUT ? frame.view->leaf_budget : 0);
  view.lod.error_px = threshold_px_;
  // A discrete level has up to four times the leaves of the cut; the error falls about as their root.
  if (view.lod.discrete) view.lod.error_px *= 0.5f;
  streamer_->set_growth_bytes(renderer_->wanted_room_bytes(instances_, *frame.view) + (scene_ ? scene_->growth_bytes : 0));
  count_overhead();
  if (scene_) stream_scene(view.lod);
  finish_reloads();
  instances_.update_bounds();
  measure_demand(instances_.blocks(), view, demands_);
  add_demand_ahead(demand_ahead_, instances_.blocks(), view, prefetch_frames_, demands_);
  for (const PlantEntry& plant : plants_)
    if (plant.open && plant.next_slot != kNoSlot) demands_[plant.next_slot] = demands_[plant.slot];
  streamer_->begin_frame({frame.frame_number, frame.completed_number, &view, demands_});

  for (const ChunkId& id : streamer_->take_evicted()) hide_chunk(id);
  for (const ChunkId& id : streamer_->take_released()) drop_chunk(id);
  for (const std::uint32_t plant : streamer_->take_closed_plants()) {
    if (std::exchange(slots_[plant].on_gpu, false)) renderer_->remove_plant(plant);
  }
  return device_state();
}

void Context::hide_chunk(ChunkId id) {
  if (id.kind == ChunkKind::texture) renderer_->hide_texture(id.plant, id.index);
}

void Context::drop_chunk(ChunkId id) {
  if (!slots_[id.plant].on_gpu) return;
  switch (id.kind) {
    case ChunkKind::page:
      return renderer_->drop_page(id.plant, id.index);
    case ChunkKind::wood:
      return renderer_->drop_wood(id.plant, id.index);
    case ChunkKind::texture:
      return renderer_->drop_texture(id.plant, id.index);
    case ChunkKind::leaf_mesh:
      return renderer_->drop_leaf_mesh(id.plant, id.index);
  }
}

Result<void> Context::upload_chunk(const DecodedChunk& chunk) {
  if (chunk.id.kind == ChunkKind::wood) return renderer_->upload_wood(chunk.id.plant, chunk.id.index, *chunk.wood);
  if (chunk.id.kind == ChunkKind::leaf_mesh) return renderer_->upload_leaf_mesh(chunk.id.plant, chunk.id.index, *chunk.wood);
  if (chunk.id.kind == ChunkKind::texture) return renderer_->upload_texture(chunk.id.plant, chunk.id.index, chunk.texture);
  return renderer_->upload_page(
      {.plant = chunk.id.plant, .page = chunk.id.index, .clusters = chunk.clusters, .ready_cuts = chunk.ready_cuts, .light = chunk.light});
}

Result<void> Context::upload_decoded() {
  const std::uint64_t start = now_ns(), spent = streamer_->hand_over_ns();
  const std::uint64_t left = streaming_ns_ - std::min(streaming_ns_, spent);
  const coppice_trace& trace = hooks_.hooks.trace;
  bool first = true;
  for (const DecodedChunk& chunk : streamer_->take_decoded(renderer_->upload_room_bytes())) {
    // The rest is handed out again. What a plant cannot be drawn without comes first and in any case.
    if (!std::exchange(first, false) && !chunk.pinned && now_ns() - start >= left) break;
    const ChunkId id = chunk.id;
    if (!streamer_->awaits_upload(id)) continue;                                                      // an earlier page of its plant failed
    if (!renderer_->has_room(chunk.bytes, id.kind == ChunkKind::wood ? chunk.wood : nullptr)) break;  // room is being made
    const std::uint64_t upload_start = trace_start(trace);
    auto uploaded = upload_chunk(chunk);
    trace_end(trace,
              {COPPICE_TRACE_UPLOAD, streamer_->path(id.plant).c_str(), chunk_kind_name(id.kind), id.index, chunk.bytes, upload_start, 0});
    COPPICE_CHECK(device_state());
    if (uploaded)
      streamer_->uploaded(id);
    else
      streamer_->upload_failed(id, uploaded.error());
  }
  return {};
}

Result<void> Context::record_upload(VkCommandBuffer cmd) {
  const TraceScope trace(hooks_.hooks.trace, COPPICE_TRACE_RECORD_UPLOAD);
  recording_ = Recording::uploaded;
  give_room();
  renderer_->record_upload_begin(cmd);
  COPPICE_CHECK(upload_decoded());
  for (std::uint32_t plant = 0; plant < slots_.size(); ++plant) {
    if (!slots_[plant].open) continue;
    const PlantState state = streamer_->state(plant);
    residency_[plant] = {state.resident_leaf_count, state.resident_wood_mask, state.leaf_meshes_resident};
  }
  auto recorded = renderer_->record_upload_end(instances_, residency_);
  count_overhead();
  COPPICE_CHECK(device_state());
  return recorded;
}

void Context::record_draw(VkCommandBuffer cmd, const coppice_view& view) const {
  const TraceScope trace(hooks_.hooks.trace, COPPICE_TRACE_RECORD_DRAW);
  renderer_->record_draw(cmd, view);
}

Result<void> Context::record_cull(VkCommandBuffer cmd, const coppice_view& view) {
  const TraceScope trace(hooks_.hooks.trace, COPPICE_TRACE_RECORD_CULL);
  COPPICE_TRY(demand, demand_view(view));
  recording_ = Recording::culled;
  if (view.leaf_budget > 0 && view.lod == COPPICE_LOD_CUT) demand.lod.error_px = std::max(demand.lod.error_px, threshold_px_);
  give_room();
  renderer_->record_cull(cmd, view, demand.lod);
  count_overhead();
  return device_state();
}

void Context::fill_stats(coppice_stats& stats) const {
  const StreamStats streaming = streamer_->stats();
  const gpu::FrameCounts& counts = renderer_->counts();
  stats.instance_count = instances_.count();
  stats.gpu_frame_number = counts.frame;
  stats.visible_instance_count = counts.visible_instances;
  stats.occluded_instance_count = counts.occluded_instances;
  stats.drawn_leaf_count = counts.leaves;
  stats.drawn_wood_triangle_count = counts.wood_triangles;
  stats.leaf_mesh_instance_count = counts.leaf_mesh_instances;
  stats.drawn_leaf_mesh_triangle_count = counts.leaf_mesh_triangles;
  stats.source_leaf_count = 0;
  for (std::uint32_t plant = 0; plant < slots_.size(); ++plant)
    if (slots_[plant].open)
      stats.source_leaf_count += std::uint64_t{instances_.plant_count(plant)} * streamer_->file(plant).plant.leaf_count;
  stats.memory_budget_bytes = streaming.budget_bytes;
  stats.memory_bytes = streaming.memory_bytes;
  stats.memory_peak_bytes = streaming.memory_peak_bytes;
  for (std::size_t kind = 0; kind < kChunkKindCount; ++kind) stats.streamed[kind] = streamed_stats(streaming.chunks[kind]);
  stats.streamed[COPPICE_STREAMED_ALL] = streamed_stats(streaming.all());
  stats.streamed[COPPICE_STREAMED_ALL].in_flight += renderer_->lists_in_flight();
  stats.threshold_px = streaming.threshold_px;
  stats.bytes_read = streaming.bytes_read;
  stats.decode_ms = 1e-6 * static_cast<double>(streaming.decode_ns);
  const SceneStats scene = scene_ ? scene_->stream->stats() : SceneStats{};
  stats.scene_instance_count = scene.instance_count;
  stats.scene_tile_count = scene.tile_count;
  stats.scene_tiles_resident = scene.resident_tiles;
  stats.scene_tiles_wanted = scene.wanted_tiles;
  stats.scene_tiles_missing = scene.missing_tiles;
  stats.scene_tiles_failed = static_cast<std::uint32_t>(scene.tiles_failed);
  stats.scene_species_failed = scene.species_failed;
  stats.scene_threshold_px = scene.threshold_px;
  static_assert(COPPICE_PASS_COUNT == static_cast<std::uint32_t>(gpu::Pass::count));
  std::ranges::copy(renderer_->timer().pass_ms(), stats.pass_ms);
}

}  // namespace coppice
