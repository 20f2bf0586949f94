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

/// Maximum number of plants that are being reloaded.
constexpr std::uint32_t kReloadSlots = 4;
/// Maximum frames that a reload waits for the new file to become as fine as is in demand.
constexpr std::uint64_t kReloadFrames = 120;
/// Maximum frames in which trim reaches its target.
constexpr std::uint64_t kTrimFrames = 120;
/// Capacity of the host once there is a plant.
constexpr std::uint32_t kFirstHostPlants = 16;
/// Bytes of a chunk that are copied at a time: some 50 us.
constexpr std::uint64_t kUploadPartBytes = 128ull << 10;

std::uint64_t nanoseconds(float ms) {
  return static_cast<std::uint64_t>(std::min(double{ms} * 1e6, 1e18));
}

/// The contexts of a process share only this counter, which tells their handles apart.
std::uint32_t next_tag() {
  static std::atomic<std::uint32_t> created{0};
  return 1 + created.fetch_add(1, std::memory_order_relaxed) % ((1u << kHandleContextBits) - 1);
}

BackendOptions backend_options(const ContextOptions& options, const Hooks& hooks, Ledger& ledger) {
  const coppice_context_desc& desc = options.desc;
  return {.hooks = hooks,
          .log = options.hooks.log,
          .ledger = ledger,
          .max_instances = desc.max_instances,
          .max_plants = desc.max_plants + kReloadSlots,
          .memory_budget_bytes = desc.memory_budget_bytes,
          .block_textures = desc.block_textures == COPPICE_TRUE};
}

StreamerOptions streamer_options(const coppice_context_desc& desc, const BackendLimits& limits) {
  return {.gpu = limits.sizes, .max_plants = limits.max_plants, .hand_over_budget_ns = nanoseconds(desc.streaming_ms)};
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

Result<std::unique_ptr<Context>> Context::create(const ContextOptions& options, const MakeBackend& make_backend) {
  const coppice_context_desc& desc = options.desc;
  std::unique_ptr<Context> context(new (std::nothrow) Context);
  if (!context) return Error{Status::out_of_memory, "context"};
  context->tag_ = next_tag();
  COPPICE_CHECK(move_into(context->hooks_, complete_hooks(options.hooks)));
  COPPICE_CHECK(move_into(context->backend_, make_backend(backend_options(options, context->hooks_.hooks, context->ledger_))));
  const BackendLimits& limits = context->limits();
  context->instances_ = gpu::InstanceTable(context->hooks_.hooks.allocator, limits.max_instances, context->tag_);
  context->scene_plants_ = {desc.asset_root != nullptr ? desc.asset_root : "", desc.allow_outside == COPPICE_TRUE,
                            context->hooks_.real_files};
  context->streaming_ns_ = nanoseconds(desc.streaming_ms);
  context->prefetch_frames_ = desc.prefetch_frames;
  COPPICE_CHECK(move_into(context->streamer_, Streamer::create(context->hooks_.hooks, context->ledger_, streamer_options(desc, limits))));
  context->max_plants_ = limits.max_plants - kReloadSlots;
  COPPICE_CHECK(check_budget(desc.memory_budget_bytes, context->least_budget(desc.memory_budget_bytes, 0)));
  context->budget_bytes_ = desc.memory_budget_bytes;
  context->ledger_.set_budget(desc.memory_budget_bytes);
  return context;
}

Result<std::uint64_t> Context::cost(const ContextOptions& options, const MakeBackend& make_backend, const AddViews& add_views,
                                    std::uint32_t instances) {
  COPPICE_CHECK(check_hooks(options.hooks));
  Ledger ledger;
  const Hooks hooks{.allocator = default_allocator()};
  COPPICE_TRY(backend, make_backend(backend_options(options, hooks, ledger)));
  COPPICE_TRY(streamer, Streamer::create(hooks, ledger, streamer_options(options.desc, backend->limits())));
  if (!add_views) return ledger.reserved();
  COPPICE_TRY(picture_bytes, add_views(*backend));
  const gpu::InstanceTable table(hooks.allocator, backend->limits().max_instances);
  const std::uint32_t slots = table.roomy(instances);
  return ledger.reserved() + backend->reserve_bytes({.slots = slots}) + table.growth_bytes(slots) + picture_bytes;
}

std::uint64_t Context::least_bytes(std::uint64_t budget_bytes, std::uint32_t slots) {
  const std::uint32_t now = instances_.capacity();
  const std::uint64_t host = ledger_.reserved() - backend_->reserved_bytes() - streamer_->evictable_bytes() - slot_upload_bytes_;
  const std::uint64_t lists = slots < now ? gpu::InstanceTable::slot_bytes(slots) - gpu::InstanceTable::slot_bytes(now)
                                          : instances_.growth_bytes(slots) + backend_->slot_upload_bytes(slots);
  return host + lists + backend_->lasting_bytes(slots, budget_bytes);
}

// Lists take a share of the budget, so that each guess is larger than the one before it.
std::uint64_t Context::least_budget(std::uint64_t bytes, std::uint32_t slots) {
  for (std::uint64_t next = least_bytes(bytes, slots); next > bytes; next = least_bytes(bytes, slots)) bytes = next;
  return bytes;
}

Result<void> Context::check_budget(std::uint64_t bytes, std::uint64_t least, Status status) {
  if (bytes >= least) return {};
  constexpr double kMiB = 1 << 20;
  char detail[200];
  std::snprintf(detail, sizeof detail, "%.1f MiB is below the %.1f MiB (%llu bytes) that this context takes at least",
                static_cast<double>(bytes) / kMiB, std::ceil(10 * static_cast<double>(least) / kMiB) / 10,
                static_cast<unsigned long long>(least));
  return Error{status, "memory budget", Error::kNoOffset, detail};
}

Result<void> Context::set_memory_budget(std::uint64_t bytes) {
  if (bytes < budget_bytes_) COPPICE_CHECK(check_budget(bytes, least_budget(bytes, shrunk_slots())));
  budget_bytes_ = bytes;
  trim_end_frame_ = 0;
  ledger_.set_budget(bytes);
  backend_->set_memory_budget(bytes);
  start_shrinking();
  return {};
}

Result<void> Context::trim(std::uint64_t target_bytes) {
  COPPICE_CHECK(check_budget(target_bytes, least_bytes(budget_bytes_, shrunk_slots())));
  if (target_bytes >= ledger_.reserved()) return {};
  trim_end_frame_ = frame_number_ + kTrimFrames;
  ledger_.set_budget(std::min(target_bytes, budget_bytes_));
  start_shrinking();
  return {};
}

void Context::start_shrinking() {
  shrinks_ = true;
  if (ledger_.reserved() > ledger_.budget()) backend_->release_pictures();
}

// A little is not worth a copy of all.
std::uint32_t Context::shrunk_slots() {
  const std::uint32_t needed = instances_.min_capacity();
  return needed < instances_.capacity() / 4 * 3 ? needed : instances_.capacity();
}

bool Context::shrink() {
  if (const std::uint32_t slots = shrunk_slots(); slots < instances_.capacity()) {
    auto smaller = instances_.resized(slots);
    if (!smaller) return false;
    const std::uint64_t before = host_bytes();
    instances_.take(*std::move(smaller));
    ledger_.release(before - host_bytes());
  }
  return backend_->shrink(instances_.capacity());
}

void Context::continue_shrinking() {
  if (shrinks_) shrinks_ = !shrink();
  if (trim_end_frame_ == 0 || (ledger_.reserved() > ledger_.budget() && frame_number_ < trim_end_frame_)) return;
  trim_end_frame_ = 0;
  ledger_.set_budget(budget_bytes_);
}

void Context::retry_failed() {
  streamer_->retry_failed();
  for (const SceneEntry& entry : scenes_)
    if (entry.scene) entry.scene->retry_failed();
}

Result<std::uint32_t> Context::open_slot(const PlantSource& source) {
  if (const auto grown = grow_plants(); !grown) {
    log_line(log(), COPPICE_LOG_ERROR, "%s: %s", source.name, grown.error().message().c_str());
    return grown.error();
  }
  COPPICE_TRY(slot, streamer_->open_plant(source));
  add_slot(slot);
  COPPICE_CHECK(show_slot(slot));
  return slot;
}

void Context::add_slot(std::uint32_t slot) {
  slots_.extend(slot + 1);
  for (BoundedList<PlantDemand>& demands : demands_) demands.extend(slot + 1);
  lod_plants_.extend(slot + 1);
}

Result<void> Context::show_slot(std::uint32_t slot) {
  const PlantFile& file = streamer_->file(slot);
  if (auto added = backend_->add_plant(slot, file, streamer_->appearance(slot), streamer_->lod_words(slot)); !added) {
    log_line(log(), COPPICE_LOG_ERROR, "%s: %s", streamer_->path(slot), added.error().message().c_str());
    streamer_->close_plant(slot);
    return added.error();
  }
  instances_.set_plant_sphere(slot, file.plant.sphere_center, file.plant.sphere_radius);
  wind_reach_share_ = std::max(wind_reach_share_, wind_reach_share(wind_field(file), file.plant.sphere_radius));
  slots_[slot].open = slots_[slot].in_backend = true;
  lod_plants_[slot] = {.table = lod_table(file, streamer_->lod_words(slot))};
  return {};
}

void Context::remove_instances(std::uint32_t slot) {
  instances_.remove_plant(slot);
  for (ViewEntry& view : views_) forget_demand(view.ahead);
}

void Context::close_slot(std::uint32_t slot) {
  remove_instances(slot);
  streamer_->close_plant(slot);
  slots_[slot].open = false;
}

Result<coppice_plant> Context::open_plant(const PlantSource& source) {
  if (free_entry() == max_plants_) {
    log_line(log(), COPPICE_LOG_ERROR, "%s: max_plants are open", source.name);
    return Error{Status::out_of_memory, "max_plants are open"};
  }
  COPPICE_TRY(slot, open_slot(source));
  const coppice_plant plant = take_entry(slot, COPPICE_PLANT_READY);
  tell_opened(slot);
  return plant;
}

Result<coppice_plant> Context::start_open(const PlantSource& source) {
  if (free_entry() == max_plants_) return Error{Status::out_of_memory, "max_plants are open"};
  COPPICE_CHECK(grow_plants());
  COPPICE_TRY(slot, streamer_->start_open(source));
  add_slot(slot);
  return take_entry(slot, COPPICE_PLANT_OPENING);
}

void Context::finish_openings() {
  const std::uint64_t end = now_ns() + streaming_ns_;
  for (PlantEntry& plant : plants_.span()) {
    if (!plant.open || plant.state != COPPICE_PLANT_OPENING) continue;
    auto opened = streamer_->finish_open(plant.slot);
    if (!opened) continue;
    if (*opened) opened = show_slot(plant.slot);
    plant.state = *opened ? COPPICE_PLANT_READY : COPPICE_PLANT_FAILED;
    if (*opened) tell_opened(plant.slot);
    if (!*opened) {
      plant.failure = opened->error().status;
      remove_instances(plant.slot);
    }
    if (now_ns() >= end) return;
  }
}

std::uint32_t Context::free_entry() const {
  const std::span<const PlantEntry> entries = plants_.span();
  return static_cast<std::uint32_t>(std::ranges::find(entries, false, &PlantEntry::open) - entries.begin());
}

coppice_plant Context::take_entry(std::uint32_t slot, coppice_plant_state state) {
  const std::uint32_t index = free_entry();
  plants_.extend(index + 1);
  PlantEntry& entry = plants_[index];
  entry.open = true;
  entry.state = state;
  entry.slot = slot;
  return slots_[slot].plant = pack_handle({HandleKind::plant, tag_, entry.generation, index});
}

bool Context::is_open(coppice_plant plant) const {
  const std::uint32_t index = unpack_handle(plant).index;
  return index < plants_.count && plants_[index].open && plant == pack_handle({HandleKind::plant, tag_, plants_[index].generation, index});
}

void Context::close_plant(coppice_plant plant) {
  PlantEntry& closing = entry(plant);
  if (closing.state == COPPICE_PLANT_READY) close_slot(closing.slot);
  if (closing.state == COPPICE_PLANT_OPENING) {
    remove_instances(closing.slot);
    streamer_->cancel_open(closing.slot);
  }
  if (closing.next_slot != kNoSlot) close_slot(closing.next_slot);
  closing = {.generation = closing.generation + 1};
}

Result<void> Context::reload_plant(coppice_plant plant, const std::optional<PlantSource>& source) {
  COPPICE_TRY(slot, open_slot(source ? *source : streamer_->source(plant_slot(plant))));
  slots_[slot].plant = plant;
  tell_opened(slot);
  PlantEntry& reloading = entry(plant);
  if (reloading.next_slot != kNoSlot) close_slot(reloading.next_slot);
  reloading.next_slot = slot;
  reloading.swap_frame = frame_number_ + kReloadFrames;
  return {};
}

// The pinned chunks of the new file must be resident in any case: from then on it can be drawn.
void Context::finish_reloads() {
  for (PlantEntry& plant : plants_.span()) {
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
  const PlantEntry& known = entry(plant);
  const std::uint32_t slot = known.slot;
  coppice_plant_info_init(&info);
  info.state = known.state;
  info.failure = static_cast<coppice_status>(known.failure);
  info.reloading = known.next_slot != kNoSlot ? COPPICE_TRUE : COPPICE_FALSE;
  if (known.state != COPPICE_PLANT_READY) return;
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

Result<void> Context::add_instances(coppice_plant plant, const gpu::PlacementRecords& placements, std::span<coppice_instance> handles) {
  COPPICE_TRY(slots, instances_.slots_for(placements.count));
  COPPICE_CHECK(grow_slots(slots));
  return instances_.add(entry(plant).slot, placements, handles);
}

Result<void> Context::check_fits(std::uint64_t bytes) {
  return ledger_.fits(bytes) ? Result<void>() : streamer_->refusal(bytes);
}

Result<void> Context::grow_slots(std::uint32_t slots) {
  const std::uint64_t upload_bytes = std::max(slot_upload_bytes_, backend_->slot_upload_bytes(slots));
  const auto growth_bytes = [&](std::uint32_t count) {
    return upload_bytes - slot_upload_bytes_ + instances_.growth_bytes(count) + backend_->reserve_bytes({.slots = count});
  };
  const std::uint32_t roomy = instances_.roomy(slots);
  const std::uint32_t count = growth_bytes(roomy) <= ledger_.free() ? roomy : slots;
  if (!ledger_.fits(growth_bytes(count))) {
    COPPICE_CHECK(check_budget(budget_bytes_, least_budget(budget_bytes_, slots), Status::out_of_memory));
    return streamer_->refusal(growth_bytes(count));
  }
  if (count > instances_.capacity()) {
    const std::uint64_t before = host_bytes();
    COPPICE_TRY(larger, instances_.resized(count));
    COPPICE_CHECK(backend_->reserve({.slots = count}));
    instances_.take(std::move(larger));
    ledger_.reserve(host_bytes());
    ledger_.release(before);
  }
  ledger_.reserve(upload_bytes - std::exchange(slot_upload_bytes_, upload_bytes));
  return {};
}

std::uint64_t Context::host_bytes() const {
  std::uint64_t bytes = plants_.items.bytes() + slots_.items.bytes() + lod_plants_.items.bytes() + instances_.bytes();
  for (const BoundedList<PlantDemand>& demands : demands_) bytes += demands.items.bytes();
  return bytes;
}

Result<void> Context::reserve_host(std::uint32_t count) {
  if (count <= slots_.items.size()) return {};
  const coppice_allocator& allocator = hooks_.hooks.allocator;
  const auto now = static_cast<std::uint32_t>(slots_.items.size());
  const std::uint32_t room = roomy_count({.now = now, .needed = count, .first = kFirstHostPlants, .maximum = limits().max_plants});
  constexpr std::uint64_t kBytesEach =
      sizeof(PlantEntry) + sizeof(PlantSlot) + kMaxViewGroups * sizeof(PlantDemand) + sizeof(LodPlant) + gpu::InstanceTable::kPlantBytes;
  COPPICE_CHECK(check_fits((room - now) * kBytesEach));
  const std::uint64_t before = host_bytes();
  auto reserved = [&]() -> Result<void> {
    COPPICE_CHECK(instances_.reserve_plants(room));
    COPPICE_CHECK(plants_.reserve(allocator, room));
    for (BoundedList<PlantDemand>& demands : demands_) COPPICE_CHECK(demands.reserve(allocator, room));
    COPPICE_CHECK(lod_plants_.reserve(allocator, room));
    return slots_.reserve(allocator, room);
  }();
  ledger_.reserve(host_bytes() - before);
  return reserved;
}

Result<void> Context::grow_plants() {
  // A failed plant has an entry and no slot.
  const auto needed = std::min(static_cast<std::uint32_t>(std::max(slots_.count, plants_.count) + 1), limits().max_plants);
  const std::uint32_t capacity = backend_->plant_capacity();
  COPPICE_CHECK(reserve_host(needed));
  for (ViewEntry& view : views_)
    if (view.open) COPPICE_CHECK(make_room(view.ahead, hooks_.hooks.allocator, ledger_, static_cast<std::uint32_t>(slots_.items.size())));
  if (needed <= capacity) return {};
  SceneSize size{.plants = roomy_count({.now = capacity, .needed = needed, .maximum = limits().max_plants})};
  if (backend_->reserve_bytes(size) > ledger_.free()) size.plants = needed;
  COPPICE_CHECK(check_fits(backend_->reserve_bytes(size)));
  return backend_->reserve(size);
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

Result<void> Context::begin_frame(const coppice_frame& frame, std::span<const coppice_camera> cameras) {
  const TraceScope trace(hooks_.hooks.trace, COPPICE_TRACE_FRAME_BEGIN);
  COPPICE_CHECK(check_numbers(frame));
  lods_.clear();
  for (const coppice_camera& camera : cameras) {
    COPPICE_TRY(lod, demand_view(camera, origin()));
    lods_.push_back(lod);
  }
  frame_number_ = frame.frame_number;
  completed_number_ = frame.completed_number;
  recording_ = Recording::begun;
  ledger_.begin_frame(frame.frame_number);
  hooks_.order->release_overdue();
  const coppice_wind& blows = *frame.wind;
  const std::size_t map_floats = blows.map == nullptr ? 0 : std::size_t{2} * blows.map_width * blows.map_height;
  FrameWind wind{
      {.wind = blows, .origin_m = origin(), .max_map_mps = max_wind_mps({blows.map, map_floats}), .reach_share = wind_reach_share_}, wind_};
  wind.before.wind.time_s = blows.time_before_s;
  for (LodView& lod : lods_) lod.reach_share = wind_reach_share_ * max_wind_load(wind.now);
  wind_ = wind.now;
  wind_.wind.map = nullptr;  // the engine's, valid only within this call
  backend_->begin_frame(frame.frame_number, frame.completed_number, wind);
  abandon_closed_upload();
  for (const ChunkId& id : streamer_->release(frame.completed_number))
    if (slots_[id.plant].in_backend) backend_->drop_chunk(id);
  for (const std::uint32_t plant : streamer_->take_closed_plants())
    if (std::exchange(slots_[plant].in_backend, false)) {
      backend_->remove_plant(plant);
      backend_->tell({COPPICE_CHANGE_PLANT_CLOSED, slots_[plant].plant, {.plant = plant}});
    }
  continue_shrinking();
  for (std::size_t i = 0; i < cameras.size(); ++i) show_view(cameras[i], lods_[i]);
  const std::uint64_t openings_start = now_ns();
  finish_openings();
  const std::uint64_t openings_ns = now_ns() - openings_start;
  const auto scene_count =
      static_cast<std::uint32_t>(std::ranges::count_if(scenes_, [](const SceneEntry& entry) { return entry.scene != nullptr; }));
  for (const SceneEntry& entry : scenes_)
    if (entry.scene) entry.scene->begin_frame(lods_, frame_number_, streaming_ns_ / scene_count, scene_count);
  finish_reloads();
  instances_.begin_frame();
  instances_.update_bounds();
  measure_views(cameras, lods_);
  StreamFrame streamed = stream_frame();
  streamed.spent_ns = openings_ns;
  streamer_->begin_frame(streamed);
  const std::span<const ChunkId> evicted = streamer_->take_evicted();
  for (const ChunkId& id : evicted) {
    backend_->hide_chunk(id);
    if (backend_->tell({COPPICE_CHANGE_CHUNK_DROPPED, slots_[id.plant].plant, id})) streamer_->await_freed(id);
  }
  if (!evicted.empty()) note_residency();
  return device_state();
}

Result<bool> Context::upload_part(const DecodedChunk& chunk, std::uint64_t max_bytes) {
  const coppice_trace& trace = hooks_.hooks.trace;
  const std::uint64_t start = trace_start(trace);
  const auto whole = backend_->upload_chunk(chunk, max_bytes);
  trace_end(trace, {0, COPPICE_TRACE_UPLOAD, streamer_->path(chunk.id.plant), chunk_kind_name(chunk.id.kind), chunk.id.index,
                    std::min(chunk.bytes, max_bytes), start, 0});
  COPPICE_CHECK(device_state());
  if (!whole)
    streamer_->upload_failed(chunk.id, whole.error());
  else if (*whole)
    streamer_->uploaded(chunk.id);
  return !whole || *whole;
}

Result<void> Context::continue_upload(std::uint64_t until_ns) {
  do {
    if (backend_->staging_bytes() < kUploadPartBytes || !ledger_.fits(limits().sizes.slack_bytes)) return {};
    COPPICE_TRY(ended, upload_part(*uploading_, kUploadPartBytes));
    if (ended) uploading_.reset();
  } while (uploading_ && now_ns() < until_ns);
  return {};
}

void Context::abandon_closed_upload() {
  if (!uploading_ || streamer_->is_open(uploading_->id.plant)) return;
  backend_->abandon_upload();
  streamer_->abandon_upload(uploading_->id);
  uploading_.reset();
}

Result<void> Context::upload_decoded() {
  const std::uint64_t until = now_ns() + streaming_ns_ - std::min(streaming_ns_, streamer_->hand_over_ns());
  const std::span<const DecodedChunk> chunks = streamer_->take_decoded(backend_->staging_bytes());
  auto next = chunks.begin();
  // Chunks without which a plant cannot be drawn have the highest value. They are uploaded at once, whatever the time.
  for (; next != chunks.end() && next->pinned; ++next) {
    if (next->bytes > backend_->staging_bytes() || !ledger_.fits(limits().sizes.slack_bytes)) break;
    if (streamer_->begin_upload(next->id)) COPPICE_CHECK(upload_part(*next, UINT64_MAX));
  }
  bool first = !uploading_;
  if (uploading_ && streamer_->is_open(uploading_->id.plant)) COPPICE_CHECK(continue_upload(until));
  for (; next != chunks.end() && !uploading_ && (std::exchange(first, false) || now_ns() < until); ++next) {
    if (!streamer_->begin_upload(next->id)) continue;  // an earlier page of its plant failed
    uploading_ = *next;
    COPPICE_CHECK(continue_upload(until));
  }
  return {};
}

void Context::note_residency() {
  for (std::uint32_t plant = 0; plant < slots_.count; ++plant)
    if (slots_[plant].open) note_residency(plant);
}

void Context::note_residency(std::uint32_t slot) {
  const PlantState state = streamer_->state(slot);
  LodPlant& plant = lod_plants_[slot];
  plant.resident_leaf_count = state.resident_leaf_count;
  plant.resident_wood_mask = state.resident_wood_mask;
  plant.leaf_meshes_resident = state.leaf_meshes_resident;
  plant.material_override = entry(slots_[slot].plant).material_override;
}

const LodPlant* Context::drawn_plant(coppice_plant plant, std::uint32_t& slot) const {
  const PlantEntry& known = entry(plant);
  if (known.state != COPPICE_PLANT_READY || !slots_[known.slot].in_backend) return nullptr;
  slot = known.slot;
  return &lod_plants_[slot];
}

Result<void> Context::upload() {
  recording_ = Recording::uploaded;
  COPPICE_CHECK(upload_decoded());
  note_residency();
  ledger_.release(std::exchange(slot_upload_bytes_, 0));
  auto recorded = backend_->end_upload(instances_, lod_plants_.span());
  COPPICE_CHECK(device_state());
  return recorded;
}

void Context::fill_stats(coppice_stats& stats) const {
  const StreamStats streaming = streamer_->stats();
  stats.instance_count = instances_.count();
  stats.source_leaf_count = 0;
  for (std::uint32_t plant = 0; plant < slots_.count; ++plant)
    if (slots_[plant].open)
      stats.source_leaf_count += std::uint64_t{instances_.plant_count(plant)} * streamer_->file(plant).plant.leaf_count;
  stats.memory_budget_bytes = budget_bytes_;
  stats.memory_bytes = ledger_.reserved();
  stats.memory_peak_bytes = ledger_.max_reserved();
  for (std::size_t kind = 0; kind < kChunkKindCount; ++kind) stats.streamed[kind] = streamed_stats(streaming.chunks[kind]);
  stats.streamed[COPPICE_STREAMED_ALL] = streamed_stats(streaming.all());
  stats.bytes_read = streaming.bytes_read;
  stats.decode_ms = 1e-6 * static_cast<double>(streaming.decode_ns);
  backend_->fill_stats(stats);
  SceneStats scene;
  for (const SceneEntry& entry : scenes_)
    if (entry.scene) add_stats(scene, entry.scene->stats());
  stats.scene_instance_count = scene.instance_count;
  stats.scene_tile_count = scene.tile_count;
  stats.scene_tiles_resident = scene.resident_tiles;
  stats.scene_tiles_wanted = scene.wanted_tiles;
  stats.scene_tiles_missing = scene.missing_tiles;
  stats.scene_tiles_failed = static_cast<std::uint32_t>(scene.tiles_failed);
  stats.scene_species_failed = scene.species_failed;
  stats.scene_threshold_px = scene.threshold_px;
}

}  // namespace coppice
