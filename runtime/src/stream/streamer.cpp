#include "streamer.h"

#include <algorithm>
#include <array>
#include <new>
#include <numeric>

#include "check.h"
#include "plant_tables.h"
#include "streamer_state.h"

namespace coppice {

namespace {

constexpr std::size_t kMaxListed = 4096;    ///< maximum of evictions and releases a frame; the rest waits for the next
constexpr std::size_t kMaxUploads = 256;    ///< maximum of chunks in a take_decoded
constexpr std::uint32_t kFirstPlants = 64;  ///< capacity at the beginning

/// Number of places in the scratch lists.
std::size_t max_requests(const PlantStream& plant) {
  return plant.chunks.size() - plant.file.plant.page_count + 1;
}

/// Bytes of those lists, which grow by half.
std::uint64_t list_bytes(const PlantStream& plant) {
  return max_requests(plant) * (sizeof(Request) + sizeof(Indivisible)) * 3 / 2;
}

}  // namespace

Streamer::Streamer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<Streamer>> Streamer::create(const Hooks& hooks, Ledger& ledger, const StreamerOptions& options) {
  COPPICE_ASSERT(options.max_plants > 0 && options.max_in_flight > 0);
  std::unique_ptr<State> state(new (std::nothrow) State(hooks, ledger, options));
  if (!state) return Error{Status::out_of_memory, "streamer"};
  COPPICE_CHECK(state->grow_plants());
  COPPICE_CHECK(allocate_into(state->transfers, hooks.allocator, options.max_in_flight));
  COPPICE_CHECK(allocate_into(state->evicted.items, hooks.allocator, kMaxListed));
  COPPICE_CHECK(state->released.make_room(hooks.allocator, kMaxListed));
  COPPICE_CHECK(allocate_into(state->decoded, hooks.allocator, kMaxUploads));
  for (Transfer& transfer : state->transfers.span()) transfer.queue = &state->completions;
  ledger.reserve(sizeof(State) + state->transfers.bytes() + state->evicted.items.bytes() + state->released.items.bytes() +
                 state->decoded.bytes() + DecoderPool::kSetBytes);
  std::unique_ptr<Streamer> streamer(new (std::nothrow) Streamer(std::move(state)));
  if (!streamer) return Error{Status::out_of_memory, "streamer"};
  return streamer;
}

// Reads that return must not start anything: only waiting is left.
Streamer::~Streamer() {
  if (!state_) return;
  state_->completions.wait_for_all();
  state_->openings.reset();  // waits for their reads
}

PlantStream& Streamer::State::open_plant_at(std::uint32_t plant) const {
  COPPICE_ASSERT(plant < plants.size() && plants[plant] != nullptr);
  return *plants[plant];
}

// Memory is reserved before anything is read or decoded. If there is none, begin_frame frees some: the GPU may still read what is evicted
// now.
Result<void> Streamer::State::reserve_for(PlantOpening& opening, std::uint64_t bytes) {
  const std::uint64_t all_bytes = opening.reserved_bytes + bytes;
  release(opening);
  if (!ledger.fits(all_bytes)) return refusal(all_bytes);
  ledger.reserve(all_bytes);
  opening.reserved_bytes = all_bytes;
  return {};
}

void Streamer::State::release(PlantOpening& opening) {
  ledger.release(std::exchange(opening.reserved_bytes, 0));
}

Result<bool> Streamer::State::advance_opening(PlantOpening& opening) {
  using Step = PlantOpening::Step;
  while (opening.idle()) {
    if (opening.step != Step::queued && opening.step != Step::decoding && repeat_read(opening, options.clock_ns)) return false;
    switch (opening.step) {
      case Step::queued: {
        if (!opening.blocking && (frame_number < opening.start_frame || started_count >= kMaxOpening)) return false;
        COPPICE_CHECK(start_header(opening, hooks, options.gpu));
        opening.plant->decoders = &decoders;
        ++started_count;
        break;
      }
      case Step::header:
        COPPICE_CHECK(take_header(opening));
        COPPICE_CHECK(reserve_for(opening, opening.plant->file.header.first_read_bytes));
        COPPICE_CHECK(start_front(opening));
        break;
      case Step::front:
        COPPICE_CHECK(take_front(opening));
        opening.plant->base_bytes += list_bytes(*opening.plant);
        COPPICE_CHECK(reserve_for(opening, opening.plant->base_bytes));
        opening.step = Step::read;
        break;
      case Step::read:
        COPPICE_CHECK(reserve_pinned(opening));
        COPPICE_CHECK(start_pinned(opening));
        break;
      case Step::decoding:
        COPPICE_CHECK(take_pinned(opening));
        COPPICE_CHECK(make_list_room(*opening.plant));
        take_opened(opening);
        return true;
    }
  }
  return false;
}

Result<void> Streamer::State::make_list_room(const PlantStream& plant) {
  std::size_t count = max_requests(plant);
  for (const auto& open : used_plants())
    if (open) count += max_requests(*open);
  COPPICE_CHECK(requests.make_room(hooks.allocator, count));
  return indivisible.make_room(hooks.allocator, count);
}

Result<void> Streamer::State::reserve_pinned(PlantOpening& opening) {
  std::uint64_t pinned_bytes = options.gpu.slack_bytes + gpu::place_plant_tables(opening.plant->file).bytes;
  for (const Chunk& chunk : opening.plant->chunks.span())
    if (chunk.pinned) pinned_bytes += chunk_bytes(*opening.plant, chunk).total();
  return reserve_for(opening, pinned_bytes);
}

void Streamer::State::take_opened(PlantOpening& opening) {
  PlantStream& plant = *opening.plant;
  release(opening);
  ledger.reserve(plant.base_bytes);
  for (Chunk& chunk : plant.chunks.span()) {
    const ChunkBytes bytes = chunk_bytes(plant, chunk);
    if (chunk.pinned) set_bytes(chunk, bytes.gpu + bytes.kept + bytes.upload);
  }
  plants[plant.index] = std::move(opening.plant);
}

PlantOpening& Streamer::State::opening_at(std::uint32_t plant) const {
  COPPICE_ASSERT(plant < plant_end && openings[plant] != nullptr && !openings[plant]->cancelled);
  return *openings[plant];
}

void Streamer::State::drop_opening(std::uint32_t plant) {
  release(*openings[plant]);
  if (openings[plant]->step != PlantOpening::Step::queued) --started_count;
  openings[plant].reset();
  if (plants[plant] == nullptr) free_index(plant);
}

Result<void> Streamer::State::grow_plants() {
  const auto now = static_cast<std::uint32_t>(plants.size());
  if (now == options.max_plants) return Error{Status::out_of_memory, "max_plants are open"};
  const std::uint32_t count = std::min(options.max_plants, std::max(kFirstPlants, 2 * now));
  constexpr std::uint64_t kBytesEach = sizeof plants[0] + sizeof openings[0] + sizeof closed.items[0];
  if (now > 0 && !ledger.fits(count * kBytesEach)) return refusal(count * kBytesEach);
  HookArray<std::unique_ptr<PlantStream>> more_plants;
  HookArray<std::unique_ptr<PlantOpening>> more_openings;
  COPPICE_CHECK(allocate_into(more_plants, hooks.allocator, count));
  COPPICE_CHECK(allocate_into(more_openings, hooks.allocator, count));
  COPPICE_TRY(more_closed, enlarged_copy(closed.items, hooks.allocator, count));
  std::ranges::move(plants.span(), more_plants.data());
  std::ranges::move(openings.span(), more_openings.data());
  plants = std::move(more_plants);
  openings = std::move(more_openings);
  closed.items = std::move(more_closed);
  ledger.reserve((count - now) * kBytesEach);
  return {};
}

Result<std::uint32_t> Streamer::State::start(const PlantSource& source, bool blocking) {
  while (first_free_plant < plant_end && (plants[first_free_plant] != nullptr || openings[first_free_plant] != nullptr)) ++first_free_plant;
  const std::uint32_t index = first_free_plant;
  if (index == plants.size()) COPPICE_CHECK(grow_plants());
  std::unique_ptr<PlantOpening> opening(new (std::nothrow) PlantOpening);
  if (!opening) return Error{Status::out_of_memory, "plant"};
  COPPICE_CHECK(move_into(opening->name, copied_text(source.name, hooks.allocator)));
  opening->source = {opening->name.data(), source.bytes};
  opening->index = index;
  opening->blocking = blocking;
  openings[index] = std::move(opening);
  plant_end = std::max(plant_end, index + 1);
  return index;
}

Result<std::uint32_t> Streamer::start_open(const PlantSource& source) {
  return state_->start(source, false);
}

std::optional<Result<void>> Streamer::finish_open(std::uint32_t plant) {
  State& s = *state_;
  PlantOpening& opening = s.opening_at(plant);
  const auto open = s.advance_opening(opening);
  if (open && !*open) return std::nullopt;
  if (!open && open.error().status == Status::out_of_memory && !opening.blocking && ++opening.failed_attempts < kOpenAttempts) {
    s.release(opening);
    if (opening.step != PlantOpening::Step::queued) --s.started_count;
    opening.restart(s.frame_number + kOpenRetryFrames);
    return std::nullopt;
  }
  if (!open) log_line(s.hooks.log, COPPICE_LOG_ERROR, "%s: %s", opening.source.name, open.error().message().c_str());
  s.drop_opening(plant);
  return open ? Result<void>() : Result<void>(open.error());
}

void Streamer::cancel_open(std::uint32_t plant) {
  PlantOpening& opening = state_->opening_at(plant);
  opening.cancelled = true;
  if (opening.idle()) state_->drop_opening(plant);
}

Result<std::uint32_t> Streamer::open_plant(const PlantSource& source) {
  auto plant = state_->start(source, true);
  if (!plant) {
    log_line(state_->hooks.log, COPPICE_LOG_ERROR, "%s: %s", source.name, plant.error().message().c_str());
    return plant;
  }
  for (;;) {
    if (auto finished = finish_open(*plant); finished) return *finished ? plant : Result<std::uint32_t>(finished->error());
    PlantOpening& opening = state_->opening_at(*plant);
    opening.wait();
    wait_until(state_->options.clock_ns, opening.retry.again_ns);
  }
}

void Streamer::close_plant(std::uint32_t plant) {
  COPPICE_ASSERT(is_open(plant));
  state_->open_plant_at(plant).closing = true;
}

bool Streamer::is_open(std::uint32_t plant) const {
  return plant < state_->plants.size() && state_->plants[plant] != nullptr && !state_->plants[plant]->closing;
}

const PlantFile& Streamer::file(std::uint32_t plant) const {
  return state_->open_plant_at(plant).file;
}

const PlantBox& Streamer::box(std::uint32_t plant) const {
  return state_->open_plant_at(plant).box;
}

std::span<const BoxTriangle> Streamer::coarse_wood(std::uint32_t plant) const {
  return state_->open_plant_at(plant).coarse_wood.span();
}

std::span<const std::uint32_t> Streamer::lod_words(std::uint32_t plant) const {
  return state_->open_plant_at(plant).lod_words;
}

gpu::PlantAppearance Streamer::appearance(std::uint32_t plant) const {
  const PlantStream& of = state_->open_plant_at(plant);
  return {of.looks, of.light};
}

PlantState Streamer::state(std::uint32_t plant) const {
  const PlantStream& of = state_->open_plant_at(plant);
  PlantState state;
  state.resident_page_count = of.resident_page_count;
  state.resident_leaf_count = static_cast<std::uint32_t>(
      std::min(std::uint64_t{of.resident_page_count} * COPPICE_PAGE_SPLITS + 1, std::uint64_t{of.file.plant.leaf_count}));
  for (const Chunk& chunk : of.chunks.span().subspan(of.file.plant.page_count)) {
    if (chunk.residency != Residency::resident) continue;
    if (chunk.id.kind == ChunkKind::wood) state.resident_wood_mask |= 1u << chunk.id.index;
    if (chunk.id.kind == ChunkKind::texture) ++state.resident_texture_count;
  }
  state.leaf_meshes_resident = leaf_meshes_resident(of);
  return state;
}

std::span<const PageNode> Streamer::page_nodes(std::uint32_t plant, std::uint32_t page) const {
  return state_->open_plant_at(plant).pages[page].nodes.span();
}

Error Streamer::refusal(std::uint64_t bytes) const {
  return state_->refusal(bytes);
}

std::span<const ChunkId> Streamer::release(std::uint64_t completed_number) {
  State& s = *state_;
  s.completed_number = completed_number;
  s.released.clear();
  s.closed.begin();
  s.release_evicted();
  s.finish_closing();
  return s.released.span();
}

void Streamer::begin_frame(const StreamFrame& frame) {
  State& s = *state_;
  COPPICE_ASSERT(frame.frame_number > s.frame_number && s.completed_number < frame.frame_number);
  s.last_frame_number = s.frame_number;
  s.frame_number = frame.frame_number;
  for (std::size_t group = 0; group < kMaxViewGroups; ++group)
    s.views[group] = frame.view_groups[group] ? std::optional(frame.view_groups[group]->view) : std::nullopt;
  s.evicted.begin();
  for (const auto& opening : s.used_openings())
    if (opening && opening->cancelled && opening->idle()) s.drop_opening(opening->index);
  for (const auto& plant : s.used_plants()) {
    if (!plant) continue;
    for (std::size_t group = 0; group < kMaxViewGroups; ++group) {
      const auto demands = frame.view_groups[group] ? frame.view_groups[group]->demands : std::span<const PlantDemand>();
      update_demand(plant->demands[group], plant->index < demands.size() ? demands[plant->index] : PlantDemand{});
    }
    s.trim(*plant);
  }
  s.update_demanded();
  s.counters.hand_over_ns = 0;
  s.retry_reads();
  s.collect_in_time(1);
  for (const auto& plant : s.used_plants())
    if (plant && plant->closing) s.advance_closing(*plant);
  s.enforce_budget();
  s.issue_requests();
  s.collect_in_time(0);
}

// Pinned chunks are evicted too, last page first.
void Streamer::State::advance_closing(PlantStream& plant) {
  if (plant.close_frame == 0) {
    plant.close_frame = frame_number;
    plant.last_used_frame = last_frame_number;
  }
  if (plant.decoding_page_count > 0) return;
  while (plant.decoded_page_count > 0 && !evicted.full() && !plant.chunk(ChunkKind::page, plant.decoded_page_count - 1).pending)
    evict(plant.chunk(ChunkKind::page, plant.decoded_page_count - 1));
  for (Chunk& chunk : plant.chunks.span().subspan(plant.file.plant.page_count))
    if ((chunk.residency == Residency::decoded || chunk.residency == Residency::resident) && !evicted.full() && !chunk.pending)
      evict(chunk);
}

void Streamer::State::finish_closing() {
  for (auto& plant : used_plants()) {
    if (!plant || plant->close_frame == 0 || closed.full()) continue;
    const auto gone = [](const Chunk& chunk) { return chunk.residency == Residency::absent || chunk.residency == Residency::failed; };
    if (plant->transfer_count > 0 || plant->evicting_count > 0 || plant->last_used_frame > completed_number) continue;
    if (!std::ranges::all_of(plant->chunks.span(), gone)) continue;
    trim(*plant);
    ledger.release(plant->base_bytes);
    closed.add(plant->index);
    free_index(plant->index);
    plant.reset();
  }
}

std::span<const ChunkId> Streamer::take_evicted() {
  return state_->evicted.take();
}
std::span<const std::uint32_t> Streamer::take_closed_plants() {
  return state_->closed.take();
}

namespace {

DecodedChunk decoded_chunk(PlantStream& plant, const Chunk& chunk) {
  DecodedChunk decoded;
  decoded.id = chunk.id;
  decoded.bytes = chunk_bytes(plant, chunk).gpu;
  decoded.pinned = chunk.pinned;
  if (chunk.id.kind == ChunkKind::page) {
    PageData& data = plant.pages[chunk.id.index];
    decoded.first_node = 2 * COPPICE_PAGE_SPLITS * chunk.id.index + 1;
    decoded.nodes = data.nodes.span();
    decoded.clusters = data.clusters.span();
    if (chunk.id.index == 0) decoded.ready_cuts = &plant.ready_cuts;
  } else if (chunk.id.kind == ChunkKind::texture) {
    decoded.texture = plant.textures[chunk.id.index].span();
  } else {
    decoded.mesh = &plant.mesh(chunk.id).block;
  }
  return decoded;
}

}  // namespace

std::span<const DecodedChunk> Streamer::take_decoded(std::uint64_t max_bytes) {
  State& s = *state_;
  s.requests.clear();
  const auto push = [&](PlantStream& plant, Chunk& chunk) {
    if (chunk.residency != Residency::decoded) return;
    s.requests.push_back({&plant, &chunk, s.value_of(plant, chunk)});
    std::ranges::push_heap(s.requests.span(), has_lower_priority);
  };
  const auto push_page = [&](PlantStream& plant, std::uint32_t page) {
    if (page < plant.decoded_page_count) push(plant, plant.chunk(ChunkKind::page, page));
  };
  for (const auto& plant : s.used_plants()) {
    if (!plant || plant->closing) continue;
    push_page(*plant, plant->resident_page_count);
    for (Chunk& chunk : plant->chunks.span().subspan(plant->file.plant.page_count)) push(*plant, chunk);
  }
  std::size_t count = 0;
  std::uint64_t bytes = 0;
  while (!s.requests.empty() && count < s.decoded.size()) {
    std::ranges::pop_heap(s.requests.span(), has_lower_priority);
    const Request offered = s.requests.pop_back();
    const std::uint64_t more = chunk_bytes(*offered.plant, *offered.chunk).gpu;
    if (count > 0 && bytes + more > max_bytes) continue;
    bytes += more;
    s.decoded[count++] = decoded_chunk(*offered.plant, *offered.chunk);
    if (offered.chunk->id.kind == ChunkKind::page) push_page(*offered.plant, offered.chunk->id.index + 1);
  }
  return {s.decoded.data(), count};
}

bool Streamer::begin_upload(ChunkId id) {
  if (!is_open(id.plant)) return false;
  PlantStream& plant = *state_->plants[id.plant];
  Chunk& chunk = plant.chunk(id.kind, id.index);
  if (chunk.residency != Residency::decoded) return false;
  const std::uint64_t bytes = chunk_bytes(plant, chunk).gpu;
  state_->set_bytes(chunk, chunk.bytes, bytes <= plant.gpu.max_staged_bytes ? bytes : 2 * bytes);
  return true;
}

void Streamer::uploaded(ChunkId id) {
  PlantStream& plant = state_->open_plant_at(id.plant);
  Chunk& chunk = plant.chunk(id.kind, id.index);
  if (id.kind == ChunkKind::page) {
    COPPICE_ASSERT(id.index == plant.resident_page_count);
    ++plant.resident_page_count;
    free_clusters(plant, id.index);
  } else {
    free_decoded(plant, id);
  }
  COPPICE_ASSERT(advance(chunk, Residency::resident));
  const ChunkBytes bytes = chunk_bytes(plant, chunk);
  state_->set_bytes(chunk, bytes.gpu + bytes.kept, bytes.gpu);
  ++state_->counts_of(chunk).loaded;
}

void Streamer::upload_failed(ChunkId id, const Error& error) {
  PlantStream& plant = state_->open_plant_at(id.plant);
  Chunk& chunk = plant.chunk(id.kind, id.index);
  const bool transient = error.status == Status::out_of_memory;
  if (transient) {
    state_->out_of_memory(plant, error);
  } else {
    const bool said = error.status == Status::device_lost && std::exchange(state_->device_lost, true);
    if (!said)
      log_line(state_->hooks.log, COPPICE_LOG_ERROR, "%s: %s %u: %s", plant.path.data(), chunk_kind_name(id.kind), id.index,
               error.message().c_str());
    ++state_->counts_of(chunk).failed;
    give_up(plant, chunk);
  }
  COPPICE_ASSERT(advance(chunk, transient ? Residency::absent : Residency::failed));
  if (id.kind == ChunkKind::page) {
    for (std::uint32_t page = id.index + 1; page < plant.decoded_page_count; ++page)
      COPPICE_ASSERT(advance(plant.chunk(ChunkKind::page, page), Residency::absent));
    plant.decoded_page_count = id.index;
    plant.trim_needed = true;
    return;  // the next begin_frame frees their memory: spans that were handed out stay valid until then
  }
  free_decoded(plant, id);
  state_->set_bytes(chunk, 0);
}

std::optional<DecodedChunk> Streamer::next_pending() {
  State& s = *state_;
  Request best;
  const auto consider = [&](PlantStream& plant, Chunk& chunk) {
    if (chunk.residency != Residency::decoded || chunk.pending) return;
    const Request offered{&plant, &chunk, s.value_of(plant, chunk)};
    if (best.chunk == nullptr || has_lower_priority(best, offered)) best = offered;
  };
  for (const auto& plant : s.used_plants()) {
    if (!plant || plant->closing) continue;
    if (plant->resident_page_count < plant->decoded_page_count) consider(*plant, plant->chunk(ChunkKind::page, plant->resident_page_count));
    for (Chunk& chunk : plant->chunks.span().subspan(plant->file.plant.page_count)) consider(*plant, chunk);
  }
  if (best.chunk == nullptr) return std::nullopt;
  best.chunk->pending = true;
  return decoded_chunk(*best.plant, *best.chunk);
}

Streamer::Pending Streamer::pending(ChunkId id) const {
  const State& s = *state_;
  if (id.plant >= s.plant_end || s.plants[id.plant] == nullptr) return Pending::no;
  const PlantStream& plant = *s.plants[id.plant];
  const coppice_file_plant& counts = plant.file.plant;
  const std::array<std::uint32_t, kChunkKindCount> maximum = {counts.page_count, counts.wood_lod_count, counts.texture_count,
                                                              counts.leaf_mesh_count};
  if (id.index >= maximum[static_cast<std::size_t>(id.kind)]) return Pending::no;
  const Chunk& chunk = plant.chunk(id.kind, id.index);
  if (!chunk.pending) return Pending::no;
  return chunk.residency == Residency::evicting ? Pending::dropped : Pending::added;
}

void Streamer::acknowledge_taken(ChunkId id) {
  PlantStream& plant = state_->open_plant_at(id.plant);
  plant.chunk(id.kind, id.index).pending = false;
  if (!plant.closing) uploaded(id);
}

void Streamer::acknowledge_refused(ChunkId id) {
  PlantStream& plant = state_->open_plant_at(id.plant);
  plant.chunk(id.kind, id.index).pending = false;
  if (!plant.closing) upload_failed(id, {Status::out_of_memory, "the host has no room"});
}

void Streamer::acknowledge_freed(ChunkId id) {
  state_->open_plant_at(id.plant).chunk(id.kind, id.index).pending = false;
}

namespace {

using CountsByKind = std::array<ChunkCounts, kChunkKindCount>;

/// Adds the chunks of `demanded` that are not resident to `wanted` and `queued`.
void count_missing(const PlantStream& plant, const DemandedDetail& demanded, CountsByKind& counts) {
  const auto count = [&](const Chunk& chunk) {
    if (chunk.residency == Residency::resident || chunk.residency == Residency::failed || !is_demanded(plant, demanded, chunk)) return;
    ChunkCounts& of = counts[static_cast<std::size_t>(chunk.id.kind)];
    ++of.wanted;
    if (chunk.residency == Residency::absent) ++of.queued;
  };
  const std::uint32_t wanted_pages = std::min(demanded.page_count, plant.loadable_page_count);
  for (std::uint32_t page = plant.resident_page_count; page < wanted_pages; ++page) count(plant.chunk(ChunkKind::page, page));
  for (const Chunk& chunk : plant.chunks.span().subspan(plant.file.plant.page_count)) count(chunk);
}

bool is_there(const PlantStream& plant, const DemandedDetail& demanded) {
  StreamStats missing;
  count_missing(plant, demanded, missing.chunks);
  return missing.all().wanted == 0;
}

}  // namespace

bool Streamer::is_settled(std::uint32_t plant) const {
  const PlantStream& of = state_->open_plant_at(plant);
  return is_there(of, of.demanded.now);
}

bool Streamer::is_group_settled(std::size_t group) const {
  if (state_->threshold_falls) return false;
  GroupViews alone;
  alone[group] = state_->views_at(state_->threshold_step)[group];
  return std::ranges::all_of(state_->used_plants(), [&](const auto& plant) {
    return !plant || plant->closing || is_there(*plant, demanded_at(*plant, DemandSize::now, alone));
  });
}

float Streamer::threshold_px(std::size_t group) const {
  const std::optional<LodView> view = state_->views_at(state_->threshold_step)[group];
  return view && !view->full ? view->error_px : 0.0f;
}

const char* Streamer::path(std::uint32_t plant) const {
  return state_->open_plant_at(plant).path.data();
}

PlantSource Streamer::source(std::uint32_t plant) const {
  const PlantStream& of = state_->open_plant_at(plant);
  return {of.path.data(), of.memory};
}

std::uint64_t Streamer::hand_over_ns() const {
  return state_->counters.hand_over_ns;
}

StreamStats Streamer::stats() const {
  const State& s = *state_;
  StreamStats stats = s.counters;
  for (const Transfer& transfer : s.transfers.span())
    if (transfer.chunk != nullptr) ++stats.chunks[static_cast<std::size_t>(transfer.chunk->id.kind)].in_flight;
  for (const auto& plant : s.used_plants())
    if (plant && !plant->closing) count_missing(*plant, plant->demanded.now, stats.chunks);
  return stats;
}

ChunkCounts& ChunkCounts::operator+=(const ChunkCounts& other) {
  loaded += other.loaded;
  evicted += other.evicted;
  failed += other.failed;
  cancelled += other.cancelled;
  in_flight += other.in_flight;
  wanted += other.wanted;
  queued += other.queued;
  return *this;
}

ChunkCounts StreamStats::all() const {
  return std::accumulate(chunks.begin(), chunks.end(), ChunkCounts{}, [](ChunkCounts sum, const ChunkCounts& of) { return sum += of; });
}

}  // namespace coppice
