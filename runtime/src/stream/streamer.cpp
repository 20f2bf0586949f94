#include "streamer.h"

#include <algorithm>
#include <array>
#include <new>

#include "check.h"
#include "loading.h"
#include "plant_opening.h"
#include "threshold.h"

namespace coppice {

namespace {

constexpr std::size_t kMaxListed = 4096;    ///< maximum of evictions and releases a frame; the rest waits for the next
constexpr std::size_t kMaxUploads = 256;    ///< maximum of chunks in a take_decoded
constexpr std::uint32_t kFirstPlants = 64;  ///< capacity at the beginning

}  // namespace

// Each part is a struct with functions in a header of its own, which use it and the parts before it.
struct Streamer::State {
  State(const Hooks& hooks, Ledger& ledger, const StreamerOptions& with)
      : options(with),
        budget{.ledger = ledger, .gpu = with.gpu},
        loading{.clock_ns = with.clock_ns, .hand_over_budget_ns = with.hand_over_budget_ns},
        openings{.hooks = hooks, .clock_ns = with.clock_ns} {}

  StreamerOptions options;
  CurrentFrame frame;
  PlantSet plants;
  Budget budget;
  Evictions evictions;
  Threshold threshold;
  Loading loading;
  Openings openings;
  BoundedList<std::uint32_t> closed;  ///< plants that have not been handed out
  HookArray<DecodedChunk> decoded;
  bool device_lost = false;  ///< true once it has been logged

  /// Reserves arrays for twice as many plants. errors  out_of_memory; nothing has changed
  Result<void> grow_plants();
  Result<std::uint32_t> start(const PlantSource& source, bool blocking);
  [[nodiscard]] PlantOpening& opening_at(std::uint32_t plant) const;
  /// Reserves scratch lists for the open plants and one more. errors  out_of_memory
  Result<void> make_list_room(const PlantStream& plant);
  /// Continues as far as finished work allows. True if the plant is open. errors  as advance_opening
  Result<bool> continue_opening(PlantOpening& opening);
  void take_demand(const StreamFrame& next);
  void evict_closing();
  void finish_closing();
  /// Cancels reads and evicts chunks until the budget is kept.
  void enforce_budget();
};

Streamer::Streamer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<Streamer>> Streamer::create(const Hooks& hooks, Ledger& ledger, const StreamerOptions& options) {
  COPPICE_ASSERT(options.max_plants > 0 && options.max_in_flight > 0);
  std::unique_ptr<State> state(new (std::nothrow) State(hooks, ledger, options));
  if (!state) return Error{Status::out_of_memory, "streamer"};
  HookArray<Transfer>& transfers = state->loading.transfers;
  Evictions& evictions = state->evictions;
  COPPICE_CHECK(state->grow_plants());
  COPPICE_CHECK(allocate_into(transfers, hooks.allocator, options.max_in_flight));
  COPPICE_CHECK(evictions.evicted.make_room(hooks.allocator, kMaxListed));
  COPPICE_CHECK(evictions.released.make_room(hooks.allocator, kMaxListed));
  COPPICE_CHECK(allocate_into(state->decoded, hooks.allocator, kMaxUploads));
  for (Transfer& transfer : transfers) transfer.queue = &state->loading.completions;
  ledger.reserve(sizeof(State) + transfers.bytes() + evictions.evicted.items.bytes() + evictions.released.items.bytes() +
                 state->decoded.bytes() + DecoderPool::kSetBytes);
  std::unique_ptr<Streamer> streamer(new (std::nothrow) Streamer(std::move(state)));
  if (!streamer) return Error{Status::out_of_memory, "streamer"};
  return streamer;
}

// Reads that return must not start anything: only waiting is left.
Streamer::~Streamer() {
  if (!state_) return;
  cancel_reads(state_->loading, state_->budget);
  for (const auto& opening : state_->openings.all.span())
    if (opening) opening->cancel();
  state_->loading.completions.wait_for_all();
  state_->openings.all.reset();  // waits for their reads
}

Result<void> Streamer::State::grow_plants() {
  const auto now = static_cast<std::uint32_t>(plants.all.size());
  if (now == options.max_plants) return Error{Status::out_of_memory, "max_plants are open"};
  const std::uint32_t count = std::min(options.max_plants, std::max(kFirstPlants, 2 * now));
  const coppice_allocator& allocator = openings.hooks.allocator;
  constexpr std::uint64_t kBytesEach = sizeof plants.all[0] + sizeof openings.all[0] + sizeof closed.items[0];
  if (now > 0 && !budget.ledger.fits(count * kBytesEach)) return coppice::refusal(budget, plants, count * kBytesEach);
  HookArray<std::unique_ptr<PlantStream>> more_plants;
  HookArray<std::unique_ptr<PlantOpening>> more_openings;
  COPPICE_CHECK(allocate_into(more_plants, allocator, count));
  COPPICE_CHECK(allocate_into(more_openings, allocator, count));
  COPPICE_CHECK(closed.reserve(allocator, count));
  std::ranges::move(plants.all, more_plants.data());
  std::ranges::move(openings.all, more_openings.data());
  plants.all = std::move(more_plants);
  openings.all = std::move(more_openings);
  budget.ledger.reserve((count - now) * kBytesEach);
  return {};
}

Result<std::uint32_t> Streamer::State::start(const PlantSource& source, bool blocking) {
  std::uint32_t& index = openings.first_free;
  while (index < plants.end && (plants.all[index] != nullptr || openings.all[index] != nullptr)) ++index;
  if (index == plants.all.size()) COPPICE_CHECK(grow_plants());
  std::unique_ptr<PlantOpening> opening(new (std::nothrow) PlantOpening);
  if (!opening) return Error{Status::out_of_memory, "plant"};
  COPPICE_CHECK(move_into(opening->name, copied_text(source.name, openings.hooks.allocator)));
  opening->source = {opening->name.data(), source.bytes};
  opening->index = index;
  opening->blocking = blocking;
  openings.all[index] = std::move(opening);
  plants.end = std::max(plants.end, index + 1);
  return index;
}

PlantOpening& Streamer::State::opening_at(std::uint32_t plant) const {
  COPPICE_ASSERT(plant < plants.end && openings.all[plant] != nullptr && !openings.all[plant]->cancelled);
  return *openings.all[plant];
}

Result<void> Streamer::State::make_list_room(const PlantStream& plant) {
  std::size_t count = max_requests(plant);
  for (const auto& open : plants.used())
    if (open) count += max_requests(*open);
  COPPICE_CHECK(loading.requests.make_room(plant.hooks.allocator, count));
  return threshold.large_lumps.make_room(plant.hooks.allocator, count);
}

Result<bool> Streamer::State::continue_opening(PlantOpening& opening) {
  COPPICE_TRY(decoded_pinned, advance_opening(openings, opening, budget, plants, frame));
  if (!decoded_pinned) return false;
  COPPICE_CHECK(make_list_room(*opening.plant));
  plants.all[opening.index] = take_opened(opening, budget);
  return true;
}

Result<std::uint32_t> Streamer::start_open(const PlantSource& source) {
  return state_->start(source, false);
}

std::optional<Result<void>> Streamer::finish_open(std::uint32_t plant) {
  State& s = *state_;
  PlantOpening& opening = s.opening_at(plant);
  const auto open = s.continue_opening(opening);
  if (open && !*open) return std::nullopt;
  if (!open && open.error().status == Status::out_of_memory && !opening.blocking && ++opening.failed_attempts < kOpenAttempts) {
    restart_opening(s.openings, opening, s.budget, s.frame.number + kOpenRetryFrames);
    return std::nullopt;
  }
  if (!open) log_line(s.openings.hooks.log, COPPICE_LOG_ERROR, "%s: %s", opening.source.name, open.error().message().c_str());
  drop_opening(s.openings, plant, s.budget, s.plants);
  return open ? Result<void>() : Result<void>(open.error());
}

void Streamer::cancel_open(std::uint32_t plant) {
  PlantOpening& opening = state_->opening_at(plant);
  opening.cancel();
  if (opening.idle()) drop_opening(state_->openings, plant, state_->budget, state_->plants);
}

Result<std::uint32_t> Streamer::open_plant(const PlantSource& source) {
  State& s = *state_;
  auto plant = s.start(source, true);
  if (!plant) {
    log_line(s.openings.hooks.log, COPPICE_LOG_ERROR, "%s: %s", source.name, plant.error().message().c_str());
    return plant;
  }
  for (;;) {
    if (auto finished = finish_open(*plant); finished) return *finished ? plant : Result<std::uint32_t>(finished->error());
    PlantOpening& opening = s.opening_at(*plant);
    opening.wait();
    wait_until(s.options.clock_ns, opening.retry.again_ns);
  }
}

void Streamer::close_plant(std::uint32_t plant) {
  COPPICE_ASSERT(is_open(plant));
  state_->plants.at(plant).closing = true;
}

bool Streamer::is_open(std::uint32_t plant) const {
  const PlantSet& plants = state_->plants;
  return plant < plants.all.size() && plants.all[plant] != nullptr && !plants.all[plant]->closing;
}

const PlantFile& Streamer::file(std::uint32_t plant) const {
  return state_->plants.at(plant).file;
}

const PlantBox& Streamer::box(std::uint32_t plant) const {
  return state_->plants.at(plant).box;
}

std::span<const BoxTriangle> Streamer::coarse_wood(std::uint32_t plant) const {
  return state_->plants.at(plant).coarse_wood.span();
}

std::span<const std::uint32_t> Streamer::lod_words(std::uint32_t plant) const {
  return state_->plants.at(plant).lod_words;
}

gpu::PlantAppearance Streamer::appearance(std::uint32_t plant) const {
  const PlantStream& of = state_->plants.at(plant);
  return {of.looks, of.light};
}

PlantState Streamer::state(std::uint32_t plant) const {
  const PlantStream& of = state_->plants.at(plant);
  PlantState state;
  state.resident_page_count = of.resident_page_count;
  state.resident_leaf_count = static_cast<std::uint32_t>(
      std::min(std::uint64_t{of.resident_page_count} * COPPICE_PAGE_SPLITS + 1, std::uint64_t{of.file.plant.leaf_count}));
  for (const Chunk& chunk : of.other_chunks()) {
    if (chunk.residency != Residency::resident) continue;
    if (chunk.id.kind == ChunkKind::wood) state.resident_wood_mask |= 1u << chunk.id.index;
    if (chunk.id.kind == ChunkKind::texture) ++state.resident_texture_count;
  }
  state.leaf_meshes_resident = leaf_meshes_resident(of);
  return state;
}

std::span<const PageNode> Streamer::page_nodes(std::uint32_t plant, std::uint32_t page) const {
  return state_->plants.at(plant).pages[page].nodes.span();
}

const char* Streamer::path(std::uint32_t plant) const {
  return state_->plants.at(plant).path.data();
}

PlantSource Streamer::source(std::uint32_t plant) const {
  const PlantStream& of = state_->plants.at(plant);
  return {of.path.data(), of.memory};
}

Error Streamer::refusal(std::uint64_t bytes) const {
  return coppice::refusal(state_->budget, state_->plants, bytes);
}

std::uint64_t Streamer::evictable_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& plant : state_->plants.used()) {
    if (!plant) continue;
    if (plant->closing) bytes += plant->base_bytes;
    for (const Chunk& chunk : plant->chunks.span())
      if (plant->closing || !chunk.pinned) bytes += chunk.reserved_bytes;
  }
  return bytes;
}

void Streamer::retry_failed() {
  for_each_open(state_->plants, [](PlantStream& plant) {
    plant.reread = {};
    forget_failures(plant, false);
  });
}

std::span<const ChunkId> Streamer::release(std::uint64_t completed_number) {
  State& s = *state_;
  s.frame.completed_number = completed_number;
  release_evicted(s.evictions, s.budget, s.plants, s.frame);
  s.finish_closing();
  return s.evictions.released.span();
}

void Streamer::begin_frame(const StreamFrame& next) {
  State& s = *state_;
  COPPICE_ASSERT(next.frame_number > s.frame.number && s.frame.completed_number < next.frame_number);
  s.frame.last_number = std::exchange(s.frame.number, next.frame_number);
  s.loading.counters.hand_over_ns = next.spent_ns;
  drop_cancelled(s.openings, s.budget, s.plants);
  s.take_demand(next);
  retry_unreadable(s.loading, s.plants);
  update_demanded(s.threshold, s.budget, s.plants, s.frame);
  retry_reads(s.loading, s.budget);
  collect(s.loading, s.budget, s.plants, s.frame, 1);
  s.evict_closing();
  s.enforce_budget();
  issue_requests(s.loading, s.evictions, s.budget, s.plants, s.frame);
  collect(s.loading, s.budget, s.plants, s.frame, 0);
}

void Streamer::State::take_demand(const StreamFrame& next) {
  for (std::size_t group = 0; group < kMaxViewGroups; ++group) {
    const std::optional<ViewGroup>& of = next.view_groups[group];
    frame.views[group] = of ? std::optional(of->view) : std::nullopt;
    const std::span<const PlantDemand> demands = of ? of->demands : std::span<const PlantDemand>();
    for (const auto& plant : plants.used())
      if (plant) update_demand(plant->demands[group], plant->index < demands.size() ? demands[plant->index] : PlantDemand{});
  }
  for (const auto& plant : plants.used())
    if (plant) trim(budget, *plant);
}

// Pinned chunks are evicted too, last page first.
void Streamer::State::evict_closing() {
  for (const auto& plant : plants.used()) {
    if (!plant || !plant->closing) continue;
    if (plant->close_frame == 0) {
      plant->close_frame = frame.number;
      plant->last_used_frame = frame.last_number;
    }
    if (plant->decoding_page_count > 0) continue;
    const auto evict_chunk = [&](Chunk& chunk) {
      const bool loaded = chunk.residency == Residency::decoded || chunk.residency == Residency::resident;
      if (!loaded || chunk.pending || evictions.evicted.full()) return false;
      evict(evictions, budget, frame, *plant, chunk);
      return true;
    };
    while (plant->decoded_page_count > 0 && evict_chunk(plant->chunk(ChunkKind::page, plant->decoded_page_count - 1))) continue;
    for (Chunk& chunk : plant->other_chunks()) evict_chunk(chunk);
  }
}

void Streamer::State::finish_closing() {
  for (auto& plant : plants.all.span().first(plants.end)) {
    if (!plant || plant->close_frame == 0 || closed.full()) continue;
    const auto gone = [](const Chunk& chunk) { return chunk.residency == Residency::absent || chunk.residency == Residency::failed; };
    if (plant->transfer_count > 0 || plant->evicting_count > 0 || plant->last_used_frame > frame.completed_number) continue;
    if (!std::ranges::all_of(plant->chunks.span(), gone)) continue;
    trim(budget, *plant);
    budget.ledger.release(plant->base_bytes);
    closed.push_back(plant->index);
    openings.first_free = std::min(openings.first_free, plant->index);
    plant.reset();
  }
}

void Streamer::State::enforce_budget() {
  const std::uint64_t limit = limit_bytes(budget, plants);
  if (budget.remaining_bytes() <= limit) return;
  cancel_reads(loading, budget);
  evict_down_to(limit, evictions, budget, plants, frame);
}

std::span<const ChunkId> Streamer::take_evicted() {
  return state_->evictions.evicted.take_all();
}
std::span<const std::uint32_t> Streamer::take_closed_plants() {
  return state_->closed.take_all();
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

/// Calls offer(plant, chunk) for each decoded chunk that may be uploaded next. The pages of a plant come in order.
template <class Offer>
void for_each_decoded(const PlantSet& plants, const Offer& offer) {
  for_each_open(plants, [&](PlantStream& plant) {
    const auto offer_decoded = [&](Chunk& chunk) {
      if (chunk.residency == Residency::decoded && !chunk.pending) offer(plant, chunk);
    };
    if (plant.resident_page_count < plant.decoded_page_count) offer_decoded(plant.chunk(ChunkKind::page, plant.resident_page_count));
    for (Chunk& chunk : plant.other_chunks()) offer_decoded(chunk);
  });
}

}  // namespace

std::span<const DecodedChunk> Streamer::take_decoded(std::uint64_t max_bytes) {
  State& s = *state_;
  BoundedList<ValuedChunk>& offers = s.loading.requests;
  offers.clear();
  const auto push = [&](PlantStream& plant, Chunk& chunk) {
    offers.push_back({&plant, &chunk, chunk_value(plant, chunk, s.frame)});
    std::ranges::push_heap(offers.span(), has_lower_priority);
  };
  for_each_decoded(s.plants, push);
  std::size_t count = 0;
  std::uint64_t bytes = 0;
  while (!offers.empty() && count < s.decoded.size()) {
    std::ranges::pop_heap(offers.span(), has_lower_priority);
    const auto [plant, chunk, value] = offers.pop_back();
    const std::uint64_t more = chunk_bytes(*plant, *chunk).gpu;
    if (count > 0 && bytes + more > max_bytes) continue;
    bytes += more;
    s.decoded[count++] = decoded_chunk(*plant, *chunk);
    const std::uint32_t next_page = chunk->id.index + 1;
    if (chunk->id.kind == ChunkKind::page && next_page < plant->decoded_page_count) push(*plant, plant->chunk(ChunkKind::page, next_page));
  }
  return {s.decoded.data(), count};
}

bool Streamer::begin_upload(ChunkId id) {
  if (!is_open(id.plant)) return false;
  PlantStream& plant = state_->plants.at(id.plant);
  Chunk& chunk = plant.chunk(id.kind, id.index);
  if (chunk.residency != Residency::decoded || chunk.pending) return false;
  const std::uint64_t bytes = chunk_bytes(plant, chunk).gpu;
  set_bytes(state_->budget, chunk, chunk.bytes, bytes);
  chunk.pending = true;
  return true;
}

void Streamer::abandon_upload(ChunkId id) {
  state_->plants.at(id.plant).chunk(id.kind, id.index).pending = false;
}

void Streamer::uploaded(ChunkId id) {
  PlantStream& plant = state_->plants.at(id.plant);
  Chunk& chunk = plant.chunk(id.kind, id.index);
  chunk.pending = false;
  if (id.kind == ChunkKind::page) {
    COPPICE_ASSERT(id.index == plant.resident_page_count);
    ++plant.resident_page_count;
    free_clusters(plant, id.index);
  } else {
    free_decoded(plant, id);
  }
  COPPICE_ASSERT(advance(chunk, Residency::resident));
  const ChunkBytes bytes = chunk_bytes(plant, chunk);
  set_bytes(state_->budget, chunk, bytes.gpu + bytes.kept, bytes.gpu);
  ++state_->loading.counts_of(chunk).loaded;
}

void Streamer::upload_failed(ChunkId id, const Error& error) {
  PlantStream& plant = state_->plants.at(id.plant);
  Chunk& chunk = plant.chunk(id.kind, id.index);
  chunk.pending = false;
  const bool transient = error.status == Status::out_of_memory;
  if (transient) {
    pause_requests(plant, state_->frame, error);
  } else {
    const bool said = error.status == Status::device_lost && std::exchange(state_->device_lost, true);
    if (!said)
      log_line(plant.hooks.log, COPPICE_LOG_ERROR, "%s: %s %u: %s", plant.path.data(), chunk_kind_name(id.kind), id.index,
               error.message().c_str());
    ++state_->loading.counts_of(chunk).failed;
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
  set_bytes(state_->budget, chunk, 0);
}

std::optional<DecodedChunk> Streamer::next_pending() {
  ValuedChunk best;
  for_each_decoded(state_->plants, [&](PlantStream& plant, Chunk& chunk) {
    const ValuedChunk offered{&plant, &chunk, chunk_value(plant, chunk, state_->frame)};
    if (best.chunk == nullptr || has_lower_priority(best, offered)) best = offered;
  });
  if (best.chunk == nullptr) return std::nullopt;
  best.chunk->pending = true;
  return decoded_chunk(*best.plant, *best.chunk);
}

Streamer::Pending Streamer::pending(ChunkId id) const {
  const PlantSet& plants = state_->plants;
  if (id.plant >= plants.end || plants.all[id.plant] == nullptr) return Pending::no;
  const PlantStream& plant = plants.at(id.plant);
  const coppice_file_plant& counts = plant.file.plant;
  const std::array<std::uint32_t, kChunkKindCount> maximum = {counts.page_count, counts.wood_lod_count, counts.texture_count,
                                                              counts.leaf_mesh_count};
  if (id.index >= maximum[static_cast<std::size_t>(id.kind)]) return Pending::no;
  const Chunk& chunk = plant.chunk(id.kind, id.index);
  if (!chunk.pending) return Pending::no;
  return chunk.residency == Residency::evicting ? Pending::dropped : Pending::added;
}

void Streamer::acknowledge_taken(ChunkId id) {
  PlantStream& plant = state_->plants.at(id.plant);
  plant.chunk(id.kind, id.index).pending = false;
  if (!plant.closing) uploaded(id);
}

void Streamer::acknowledge_refused(ChunkId id) {
  PlantStream& plant = state_->plants.at(id.plant);
  plant.chunk(id.kind, id.index).pending = false;
  if (!plant.closing) upload_failed(id, {Status::out_of_memory, "the host has no room"});
}

void Streamer::await_freed(ChunkId id) {
  state_->plants.at(id.plant).chunk(id.kind, id.index).pending = true;
}

void Streamer::acknowledge_freed(ChunkId id) {
  state_->plants.at(id.plant).chunk(id.kind, id.index).pending = false;
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
  for (const Chunk& chunk : plant.other_chunks()) count(chunk);
}

bool is_there(const PlantStream& plant, const DemandedDetail& demanded) {
  StreamStats missing;
  count_missing(plant, demanded, missing.chunks);
  return missing.all().wanted == 0;
}

}  // namespace

bool Streamer::is_settled(std::uint32_t plant) const {
  const PlantStream& of = state_->plants.at(plant);
  return is_there(of, of.demanded.now);
}

bool Streamer::is_group_settled(std::size_t group) const {
  if (state_->threshold.falls) return false;
  GroupViews alone;
  alone[group] = state_->frame.views[group];
  const Ladder ladder = current_ladder(state_->threshold, alone);
  return std::ranges::all_of(state_->plants.used(), [&](const auto& plant) {
    return !plant || plant->closing || is_there(*plant, demanded_at(*plant, DemandSize::now, ladder.of(plant->index)));
  });
}

float Streamer::threshold_px(std::size_t group) const {
  const std::optional<LodView> view = threshold_views(state_->threshold, state_->frame.views)[group];
  return view && !view->full ? view->error_px : 0.0f;
}

std::uint64_t Streamer::hand_over_ns() const {
  return state_->loading.counters.hand_over_ns;
}

StreamStats Streamer::stats() const {
  const State& s = *state_;
  StreamStats stats = s.loading.counters;
  for (std::size_t kind = 0; kind < kChunkKindCount; ++kind) stats.chunks[kind].evicted = s.evictions.counts[kind];
  for (const Transfer& transfer : s.loading.transfers.span())
    if (transfer.chunk != nullptr) ++stats.chunks[static_cast<std::size_t>(transfer.chunk->id.kind)].in_flight;
  for_each_open(s.plants, [&](const PlantStream& plant) { count_missing(plant, plant.demanded.now, stats.chunks); });
  return stats;
}

ChunkCounts StreamStats::all() const {
  ChunkCounts sum;
  for (const ChunkCounts& of : chunks) {
    sum.loaded += of.loaded;
    sum.evicted += of.evicted;
    sum.failed += of.failed;
    sum.cancelled += of.cancelled;
    sum.in_flight += of.in_flight;
    sum.wanted += of.wanted;
    sum.queued += of.queued;
  }
  return sum;
}

}  // namespace coppice
