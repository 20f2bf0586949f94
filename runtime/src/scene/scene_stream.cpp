#include "scene_stream.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <string_view>
#include <vector>

#include "bounded_list.h"
#include "check.h"
#include "completion_queue.h"
#include "io_result.h"

namespace coppice {
namespace {

/// Resident tiles stay until they are this much smaller than those in demand, so a camera that moves back and forth reads nothing.
constexpr float kKeepShare = 0.8f;
/// Frames until the next attempt after the allocator hook had no memory.
constexpr std::uint64_t kRetryFrames = 60;

enum class TileState : std::uint8_t {
  absent,
  unread,      ///< absent; no attempt could read it, so the next is a single one and is not logged
  reading,     ///< the I/O hook or a job works on it
  decoded,     ///< waits for its species, or for its turn
  resident,    ///< its instances are placed
  unreadable,  ///< logged once, read again later
  damaged,     ///< logged once
};

bool is_absent(TileState state) {
  return state == TileState::absent || state == TileState::unread;
}
bool has_failed(TileState state) {
  return state == TileState::unreadable || state == TileState::damaged;
}

enum class ReadStage : std::uint8_t {
  idle,
  reading,
  paused,  ///< the read failed and is tried again later
  decoding,
  done,
};

/// A tile that is being loaded. While a hook owns it, the frame's thread leaves it alone.
struct Read {
  ReadStage stage = ReadStage::idle;
  bool again = false;      ///< its tile was TileState::unread
  bool cancelled = false;  ///< nobody needs its bytes
  CompletionQueue<Read>* queue = nullptr;
  const SceneFile* scene = nullptr;
  std::uint32_t tile = 0;
  HookBuffer bytes;
  std::int64_t bytes_read = 0;
  ReadRetry retry;
  HookArray<SceneInstance> instances;
  Result<void> outcome;
  bool species_settled = false;  ///< all of its species are open or have failed
  Read* next = nullptr;          ///< in the queue
};

void on_read(void* argument, std::int64_t bytes_read) {
  auto* read = static_cast<Read*>(argument);
  read->bytes_read = bytes_read;
  read->queue->push(read);
}

void run_decode(void* argument) {
  auto* read = static_cast<Read*>(argument);
  read->outcome = read_scene_tile(*read->scene, read->scene->tiles[read->tile], read->bytes.span(), read->instances.span());
  read->queue->push(read);
}

std::string_view folder_of(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string_view::npos ? std::string_view() : path.substr(0, slash + 1);
}

struct SpeciesEntry {
  SpeciesState state = SpeciesState::unknown;
  const char* path = nullptr;  ///< points into species_paths, with the scene's folder
};

}  // namespace

struct SceneStream::State {
  State(const Hooks& of, Ledger& shared_ledger, const SceneStreamOptions& with) : hooks(of), ledger(shared_ledger), options(with) {}

  Hooks hooks;
  Ledger& ledger;
  std::uint64_t reserved_bytes = 0;  ///< without those of reads
  SceneStreamOptions options;
  HookArray<char> path;
  std::int64_t io_file = -1;
  SceneFile file;
  HookArray<TileState> tiles;
  HookArray<std::uint64_t> wanted_frame;  ///< [tile] the last frame in which it was in demand
  HookArray<std::uint32_t> resident;      ///< [resident_count] in any order
  std::uint32_t resident_count = 0;
  HookArray<SpeciesEntry> species;
  HookArray<char> species_paths;  ///< zero-terminated
  HookArray<Read> reads;
  CompletionQueue<Read> queue;
  std::uint64_t frame = 0, retry_frame = 0;
  Reread reread;  ///< of unreadable tiles

  // They have their maximum size from the start, so that the scene's memory does not grow with the view.
  BoundedList<TileSize> sizes;            ///< scratch: tiles near the threshold, in this frame
  BoundedList<TileSize> requests;         ///< scratch: tiles to request
  BoundedList<TileSize> small;            ///< scratch: tiles to drop, by place in `resident`
  HookArray<std::uint32_t> tile_scratch;  ///< [tile]
  BoundedList<std::uint32_t> dropped;
  std::uint32_t used_blocks = 0;  ///< blocks of tiles that are being loaded or resident
  std::vector<SceneEye> eyes;     ///< those of the frame's views
  float threshold_px = 0.0f;
  SceneStats counters;

  ~State() {
    for (Read& read : reads.span())
      if (read.stage == ReadStage::reading) cancel_read(hooks.io, io_file, &read);
    queue.wait_for_all();
    if (io_file >= 0) hooks.io.close(hooks.io.user, io_file);
    ledger.release(reserved_bytes);
    for (const Read& read : reads.span()) ledger.release(read.bytes.bytes() + read.instances.bytes());
  }

  Result<void> allocate();
  Result<void> reserve_own_memory();
  Result<void> name_species();
  Read* idle_read();
  void retry_reads();
  void start_read(Read& read);
  void fail_read(Read& read);
  void collect();
  void finish(Read& read);
  void tell_failure(std::uint32_t tile, const Error& error);
  void forget_failures(bool unreadable_only);
  void free_bytes(Read& read);
  void free_read(Read& read);
  void give_up_tile(std::uint32_t tile);
  void choose(std::uint32_t block_count);
  void drop_small(float below_px, std::uint32_t max_blocks);
  void request_tiles(std::uint32_t block_count);
  bool start_tile(std::uint32_t tile);
  bool settle_species(Read& read);
  void out_of_memory(const Error& error);
};

SceneStream::SceneStream(std::unique_ptr<State> state) : state_(std::move(state)) {}
SceneStream::~SceneStream() = default;

namespace {

Result<SceneFile> read_front_now(const Hooks& hooks, std::int64_t io_file, std::uint64_t file_bytes, std::uint64_t (*clock_ns)()) {
  std::array<std::uint8_t, kSceneHeaderBytes> header_bytes{};
  if (file_bytes < header_bytes.size())
    return Error{Status::bad_file, "header: the file is shorter than one", 0, std::to_string(file_bytes) + " bytes"};
  COPPICE_CHECK(read_now(hooks.io, io_file, header_bytes, clock_ns));
  COPPICE_TRY(header, read_scene_header(header_bytes, file_bytes));
  COPPICE_TRY(front, HookBuffer::allocate(hooks.allocator, static_cast<std::size_t>(scene_front_bytes(header))));
  COPPICE_CHECK(read_now(hooks.io, io_file, front.span(), clock_ns));
  return read_scene_front(front.span(), file_bytes, hooks.allocator);
}

}  // namespace

Result<void> SceneStream::State::allocate() {
  const std::size_t tile_count = file.tiles.size();
  COPPICE_CHECK(allocate_into(tiles, hooks.allocator, tile_count));
  COPPICE_CHECK(allocate_into(wanted_frame, hooks.allocator, tile_count));
  COPPICE_CHECK(allocate_into(resident, hooks.allocator, tile_count));
  COPPICE_CHECK(allocate_into(tile_scratch, hooks.allocator, tile_count));
  COPPICE_CHECK(dropped.make_room(hooks.allocator, tile_count));
  for (BoundedList<TileSize>* scratch : {&sizes, &requests, &small}) COPPICE_CHECK(scratch->make_room(hooks.allocator, tile_count));
  COPPICE_CHECK(name_species());
  return allocate_into(reads, hooks.allocator, options.max_in_flight);
}

Result<void> SceneStream::State::name_species() {
  const std::string_view folder = folder_of(path.data());
  COPPICE_CHECK(allocate_into(species, hooks.allocator, file.species.size()));
  COPPICE_CHECK(allocate_into(species_paths, hooks.allocator, file.paths.size() + file.species.size() * (folder.size() + 1)));
  char* text = species_paths.data();
  for (std::size_t i = 0; i < species.size(); ++i) {
    species[i].path = text;
    text = std::ranges::copy(folder, text).out;
    text = std::ranges::copy(file.species[i].path, text).out;
    *text++ = 0;
  }
  return {};
}

Result<std::unique_ptr<SceneStream>> SceneStream::open(const Hooks& hooks, Ledger& ledger, const char* path,
                                                       const SceneStreamOptions& options) {
  COPPICE_ASSERT(options.min_px > 0.0f && options.max_in_flight > 0);
  std::unique_ptr<State> state(new (std::nothrow) State(hooks, ledger, options));
  if (!state) return Error{Status::out_of_memory, "scene"};
  const auto opened = [&]() -> Result<void> {
    COPPICE_CHECK(move_into(state->path, copied_text(path, hooks.allocator)));
    std::uint64_t file_bytes = 0;
    state->io_file = hooks.io.open(hooks.io.user, path, &file_bytes);
    if (state->io_file < 0) return open_error(state->io_file);
    COPPICE_CHECK(move_into(state->file, read_front_now(hooks, state->io_file, file_bytes, options.clock_ns)));
    COPPICE_CHECK(state->allocate());
    return state->reserve_own_memory();
  }();
  if (!opened) {
    log_line(hooks.log, COPPICE_LOG_ERROR, "%s: %s", path, opened.error().message().c_str());
    return opened.error();
  }
  for (Read& read : state->reads.span()) {
    read.queue = &state->queue;
    read.scene = &state->file;
  }
  state->counters.instance_count = state->file.header.instance_count;
  state->counters.tile_count = state->file.header.tile_count;
  state->threshold_px = options.min_px;
  std::unique_ptr<SceneStream> stream(new (std::nothrow) SceneStream(std::move(state)));
  if (!stream) return Error{Status::out_of_memory, "scene"};
  return stream;
}

// Counts the memory that exists from the start.
Result<void> SceneStream::State::reserve_own_memory() {
  const std::uint64_t bytes = sizeof(State) + path.bytes() + tiles.bytes() + wanted_frame.bytes() + resident.bytes() + reads.bytes() +
                              file.tiles.bytes() + file.species.bytes() + file.paths.bytes() + species.bytes() + species_paths.bytes() +
                              tile_scratch.bytes() + sizes.items.bytes() + requests.items.bytes() + small.items.bytes() +
                              dropped.items.bytes();
  if (!ledger.fits(bytes)) return Error{Status::out_of_memory, "memory budget: no room now; try again in a few frames"};
  ledger.reserve(bytes);
  reserved_bytes = bytes;
  return {};
}

const SceneFile& SceneStream::file() const {
  return state_->file;
}

void SceneStream::begin_frame(std::span<const SceneEye> eyes, std::uint32_t block_count) {
  State& s = *state_;
  ++s.frame;
  s.eyes.assign(eyes.begin(), eyes.end());
  s.dropped.clear();
  s.collect();
  s.retry_reads();
  s.choose(block_count);
  s.collect();  // hooks that answered inline
}

Read* SceneStream::State::idle_read() {
  const auto it = std::ranges::find(reads.span(), ReadStage::idle, &Read::stage);
  return it == reads.span().end() ? nullptr : &*it;
}

void SceneStream::State::collect() {
  while (Read* read = queue.take()) finish(*read);
}

void SceneStream::State::free_bytes(Read& read) {
  ledger.release(read.bytes.bytes());
  read.bytes = {};
}

void SceneStream::State::free_read(Read& read) {
  free_bytes(read);
  ledger.release(read.instances.bytes());
  read.instances = {};
  read.outcome = {};
  read.retry = {};
  read.again = read.cancelled = read.species_settled = false;
  read.stage = ReadStage::idle;
}

void SceneStream::State::start_read(Read& read) {
  read.stage = ReadStage::reading;
  queue.expect();
  hooks.io.read(hooks.io.user, io_file, file.tiles[read.tile].offset, read.bytes.data(), read.bytes.size(), on_read, &read);
}

void SceneStream::State::retry_reads() {
  if (reread.take(options.clock_ns)) forget_failures(true);
  for (Read& read : reads.span()) {
    const bool can_cancel = read.stage == ReadStage::reading && !read.cancelled && hooks.io.cancel != nullptr;
    if (read.stage != ReadStage::paused && !can_cancel) continue;
    const bool too_small = tile_size_px(file.tiles[read.tile], eyes) < kKeepShare * threshold_px;
    if (can_cancel && too_small) {
      read.cancelled = true;
      cancel_read(hooks.io, io_file, &read);
    } else if (can_cancel) {
      continue;
    } else if (too_small) {
      give_up_tile(read.tile);
      free_read(read);
    } else if (options.clock_ns() >= read.retry.again_ns) {
      start_read(read);
    }
  }
}

// A lack of memory is temporary; other failures have a few attempts.
void SceneStream::State::fail_read(Read& read) {
  const Error error = read_error(read.bytes_read, read.bytes.size(), file.tiles[read.tile].offset);
  if (error.status == Status::out_of_memory) {
    out_of_memory(error);
    give_up_tile(read.tile);
  } else if (!read.again && read.retry.pause(options.clock_ns())) {
    read.stage = ReadStage::paused;
    return;
  } else {
    reread.schedule(options.clock_ns(), read.again);
    if (!read.again) tell_failure(read.tile, error);
    give_up_tile(read.tile);
    tiles[read.tile] = TileState::unreadable;
    ++counters.tiles_failed;
  }
  free_read(read);
}

void SceneStream::State::give_up_tile(std::uint32_t tile) {
  tiles[tile] = TileState::absent;
  used_blocks -= tile_blocks(file.tiles[tile]);
}

void SceneStream::State::tell_failure(std::uint32_t tile, const Error& error) {
  log_line(hooks.log, COPPICE_LOG_ERROR, "%s: tile %u: %s", path.data(), tile, error.message().c_str());
}

void SceneStream::State::forget_failures(bool unreadable_only) {
  for (TileState& tile : tiles.span())
    if (tile == TileState::unreadable || (tile == TileState::damaged && !unreadable_only))
      tile = unreadable_only ? TileState::unread : TileState::absent;
  counters.tiles_failed = static_cast<std::uint64_t>(std::ranges::count_if(tiles.span(), has_failed));
}

void SceneStream::State::out_of_memory(const Error& error) {
  if (frame >= retry_frame) log_line(hooks.log, COPPICE_LOG_WARNING, "%s: %s; trying again later", path.data(), error.message().c_str());
  retry_frame = frame + kRetryFrames;
}

void SceneStream::State::finish(Read& read) {
  const SceneTile& tile = file.tiles[read.tile];
  if (read.stage == ReadStage::reading && read.cancelled) {
    give_up_tile(read.tile);
    return free_read(read);
  }
  if (read.stage == ReadStage::reading) {
    if (read.bytes_read != static_cast<std::int64_t>(read.bytes.size())) return fail_read(read);
    read.stage = ReadStage::decoding;
    queue.expect();
    const coppice_job job = make_job(COPPICE_JOB_DECODE, COPPICE_PRIORITY_HIGH, run_decode, &read);
    hooks.jobs.submit(hooks.jobs.user, &job);
    return;
  }
  if (!read.outcome) {
    tell_failure(read.tile, read.outcome.error());
    give_up_tile(read.tile);
    tiles[read.tile] = TileState::damaged;
    ++counters.tiles_failed;
    return free_read(read);
  }
  // By now it is far too small: it was decoded in vain.
  if (tile_size_px(tile, eyes) < kKeepShare * threshold_px) {
    give_up_tile(read.tile);
    return free_read(read);
  }
  free_bytes(read);
  read.stage = ReadStage::done;
  tiles[read.tile] = TileState::decoded;
  for (const SceneInstance& instance : read.instances.span())
    if (SpeciesEntry& entry = species[instance.species]; entry.state == SpeciesState::unknown) entry.state = SpeciesState::wanted;
}

// Chooses the largest tiles that fit, and requests them by size until reads run out.
void SceneStream::State::choose(std::uint32_t block_count) {
  sizes.count = gather_tiles(file, eyes, options.min_px, tile_scratch.span(), sizes.items.span());
  for (TileSize& size : sizes.span()) size.kept = !is_absent(tiles[size.tile]) && !has_failed(tiles[size.tile]);
  threshold_px = fit_tiles(file, sizes.span(), options.min_px, block_count, tile_scratch.span());
  for (const TileSize& size : sizes.span())
    if (size.wanted) wanted_frame[size.tile] = frame;
  drop_small(kKeepShare * threshold_px, 0);
  if (used_blocks > block_count) drop_small(INFINITY, block_count);
  request_tiles(block_count);
}

// Drops resident tiles that are smaller than below_px and not wanted, smallest first, until no more than max_blocks are used.
void SceneStream::State::drop_small(float below_px, std::uint32_t max_blocks) {
  small.clear();
  for (std::uint32_t i = 0; i < resident_count; ++i)
    if (const float px = tile_size_px(file.tiles[resident[i]], eyes); px < below_px && wanted_frame[resident[i]] != frame)
      small.push_back({.tile = i, .size_px = px});
  const std::span<TileSize> leaving = small.span();
  std::ranges::sort(leaving, {}, &TileSize::size_px);
  std::size_t count = 0;
  for (; count < leaving.size() && used_blocks > max_blocks; ++count) {
    const std::uint32_t tile = resident[leaving[count].tile];
    give_up_tile(tile);
    dropped.push_back(tile);
    ++counters.tiles_dropped;
  }
  // From the back, so that the tile that fills a hole is none of the dropped.
  std::ranges::sort(leaving.first(count), std::greater{}, &TileSize::tile);
  for (std::size_t i = 0; i < count; ++i) resident[leaving[i].tile] = resident[--resident_count];
}

void SceneStream::State::request_tiles(std::uint32_t block_count) {
  requests.clear();
  counters.wanted_tiles = counters.missing_tiles = 0;
  std::uint32_t missing_blocks = 0;
  for (const TileSize& size : sizes.span()) {
    if (!size.wanted) continue;
    ++counters.wanted_tiles;
    if (tiles[size.tile] == TileState::resident || has_failed(tiles[size.tile])) continue;
    ++counters.missing_tiles;
    if (!is_absent(tiles[size.tile])) continue;
    requests.push_back(size);
    missing_blocks += tile_blocks(file.tiles[size.tile]);
  }
  const std::span<TileSize> requested = requests.span();
  if (requested.empty() || frame < retry_frame) return;
  // Tiles that are kept beyond the threshold make way for those in demand.
  if (used_blocks + missing_blocks > block_count) drop_small(INFINITY, block_count - std::min(missing_blocks, block_count));
  const std::size_t count = std::min<std::size_t>(requested.size(), reads.size());
  std::ranges::partial_sort(requested, requested.begin() + static_cast<std::ptrdiff_t>(count), std::greater{}, &TileSize::size_px);
  for (std::size_t i = 0; i < count && idle_read() != nullptr; ++i) {
    if (used_blocks + tile_blocks(file.tiles[requested[i].tile]) > block_count) break;
    if (!start_tile(requested[i].tile)) break;
  }
}

bool SceneStream::State::start_tile(std::uint32_t index) {
  const SceneTile& tile = file.tiles[index];
  const std::uint64_t needed_bytes = tile.bytes + std::uint64_t{tile.entry.instance_count} * sizeof(SceneInstance);
  if (!ledger.fits(needed_bytes)) return false;
  auto bytes = HookBuffer::allocate(hooks.allocator, tile.bytes);
  auto instances = HookArray<SceneInstance>::allocate(hooks.allocator, tile.entry.instance_count);
  if (!bytes || !instances) {
    out_of_memory(bytes ? instances.error() : bytes.error());
    return false;
  }
  Read& read = *idle_read();
  read.tile = index;
  read.bytes = *std::move(bytes);
  read.instances = *std::move(instances);
  read.again = std::exchange(tiles[index], TileState::reading) == TileState::unread;
  used_blocks += tile_blocks(tile);
  ledger.reserve(needed_bytes);
  start_read(read);
  return true;
}

std::span<const std::uint32_t> SceneStream::dropped() const {
  return state_->dropped.span();
}

bool SceneStream::State::settle_species(Read& read) {
  read.species_settled = read.species_settled || std::ranges::all_of(read.instances.span(), [this](const SceneInstance& instance) {
                           const SpeciesState state = species[instance.species].state;
                           return state == SpeciesState::open || state == SpeciesState::failed;
                         });
  return read.species_settled;
}

std::optional<ReadyTile> SceneStream::next_ready() {
  State& s = *state_;
  const Read* best = nullptr;
  float best_px = 0.0f;
  for (Read& read : s.reads.span()) {
    if (read.stage != ReadStage::done) continue;
    const float px = tile_size_px(s.file.tiles[read.tile], s.eyes);
    if ((best != nullptr && px <= best_px) || !s.settle_species(read)) continue;
    best = &read;
    best_px = px;
  }
  if (best == nullptr) return {};
  return ReadyTile{best->tile, best_px, best->instances.span()};
}

namespace {

Read& read_of(std::span<Read> reads, std::uint32_t tile) {
  const auto it = std::ranges::find_if(reads, [&](const Read& read) { return read.stage == ReadStage::done && read.tile == tile; });
  COPPICE_ASSERT(it != reads.end());
  return *it;
}

}  // namespace

void SceneStream::placed(std::uint32_t tile) {
  State& s = *state_;
  s.free_read(read_of(s.reads.span(), tile));
  s.tiles[tile] = TileState::resident;
  s.resident[s.resident_count++] = tile;
  ++s.counters.tiles_loaded;
}

void SceneStream::refused(std::uint32_t tile) {
  State& s = *state_;
  s.free_read(read_of(s.reads.span(), tile));
  s.give_up_tile(tile);
  s.retry_frame = s.frame + kRetryFrames;
}

std::optional<WantedSpecies> SceneStream::next_species() {
  State& s = *state_;
  for (std::uint32_t i = 0; i < s.species.size(); ++i) {
    if (s.species[i].state != SpeciesState::wanted) continue;
    const auto allowed = check_species_path(s.options.plants, s.path.data(), s.file.species[i].path);
    if (allowed) return WantedSpecies{i, s.species[i].path};
    const bool outside = allowed.error().status == Status::invalid_argument;
    log_line(s.hooks.log, COPPICE_LOG_ERROR, "%s: plant %u: %s%s", s.path.data(), i, allowed.error().message().c_str(),
             outside ? "; asset_root and allow_outside of the context say what is allowed" : "");
    species_opened(i, false);
  }
  return {};
}

void SceneStream::species_opening(std::uint32_t species) {
  state_->species[species].state = SpeciesState::opening;
}

void SceneStream::species_opened(std::uint32_t species, bool success) {
  if (!success) ++state_->counters.species_failed;
  state_->species[species].state = success ? SpeciesState::open : SpeciesState::failed;
}

const char* SceneStream::species_path(std::uint32_t species) const {
  return state_->species[species].path;
}

SpeciesState SceneStream::species_state(std::uint32_t species) const {
  return state_->species[species].state;
}

void add_stats(SceneStats& sum, const SceneStats& other) {
  sum.instance_count += other.instance_count;
  sum.tile_count += other.tile_count;
  sum.resident_tiles += other.resident_tiles;
  sum.wanted_tiles += other.wanted_tiles;
  sum.missing_tiles += other.missing_tiles;
  sum.threshold_px = std::max(sum.threshold_px, other.threshold_px);
  sum.tiles_loaded += other.tiles_loaded;
  sum.tiles_dropped += other.tiles_dropped;
  sum.tiles_failed += other.tiles_failed;
  sum.species_failed += other.species_failed;
}

void SceneStream::retry_failed() {
  state_->reread = {};
  state_->forget_failures(false);
}

SceneStats SceneStream::stats() const {
  SceneStats stats = state_->counters;
  stats.resident_tiles = state_->resident_count;
  stats.threshold_px = state_->threshold_px;
  return stats;
}

}  // namespace coppice
