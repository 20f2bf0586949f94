// Advances transfers in a frame. A transfer is handled when its read returns and again when its decode returns: it moves on, fails, or is
// dropped because its chunk is no longer in demand.

#include <algorithm>

#include "check.h"
#include "streamer_state.h"

namespace coppice {

namespace {

constexpr std::uint64_t kRetryFrames = 30;

bool on_its_way(const Chunk& chunk) {
  return chunk.residency == Residency::reading || chunk.residency == Residency::decoding;
}

}  // namespace

bool has_lower_priority(const Request& a, const Request& b) {
  if (a.value != b.value) return a.value < b.value;
  if (a.plant != b.plant) return a.plant->index > b.plant->index;
  if (a.chunk->id.kind != b.chunk->id.kind) return a.chunk->id.kind > b.chunk->id.kind;
  return a.chunk->id.index > b.chunk->id.index;
}

void Streamer::State::free_transfer(Transfer& transfer) {
  if (transfer.cancelled) cancelled_bytes -= transfer.bytes.size();
  --transfer.plant->transfer_count;
  transfer = Transfer{.queue = transfer.queue};
}

void Streamer::State::drop(Transfer& transfer) {
  Chunk& chunk = *transfer.chunk;
  PlantStream& plant = *transfer.plant;
  if (chunk.residency == Residency::reading) ++counts_of(chunk).cancelled;
  free_transfer(transfer);
  COPPICE_ASSERT(advance(chunk, Residency::absent));
  plant.trim_needed = true;
  if (chunk.id.kind != ChunkKind::page || plant.page_nodes[chunk.id.index] == nullptr) set_bytes(chunk, 0);
  trim(plant);
}

void Streamer::State::fail(Transfer& transfer, const Error& error) {
  Chunk& chunk = *transfer.chunk;
  PlantStream& plant = *transfer.plant;
  Error placed = error;
  if (placed.offset == Error::kNoOffset) placed.offset = plant.file_chunk(chunk).offset;
  log_line(hooks.log, COPPICE_LOG_ERROR, "%s: %s %u: %s", plant.path.data(), chunk_kind_name(chunk.id.kind), chunk.id.index,
           placed.message().c_str());
  ++counts_of(chunk).failed;
  give_up(plant, chunk);
  free_transfer(transfer);
  COPPICE_ASSERT(advance(chunk, Residency::failed));
  plant.trim_needed = true;
  if (chunk.id.kind != ChunkKind::page || plant.page_nodes[chunk.id.index] == nullptr) set_bytes(chunk, 0);
  trim(plant);
}

void Streamer::State::out_of_memory(PlantStream& plant, const Error& error) {
  if (frame_number >= plant.retry_frame)
    log_line(hooks.log, COPPICE_LOG_WARNING, "%s: %s; stays coarse", plant.path.data(), error.message().c_str());
  plant.retry_frame = frame_number + kRetryFrames;
}

// A job that decodes a later page reads the nodes of earlier ones, so their memory is freed only when no job runs for the plant.
void Streamer::State::trim(PlantStream& plant) {
  if (!plant.trim_needed || plant.decoding_page_count > 0) return;
  for (std::uint32_t page = plant.decoded_page_count; page < plant.file.plant.page_count; ++page) {
    Chunk& chunk = plant.chunk(ChunkKind::page, page);
    if (chunk.residency != Residency::absent && chunk.residency != Residency::failed) continue;
    if (chunk.bytes == 0 && plant.page_nodes[page] == nullptr) continue;
    free_page(plant, page);
    set_bytes(chunk, 0);
  }
  plant.trim_needed = false;
}

bool Streamer::State::stale(const Transfer& transfer) const {
  const PlantStream& plant = *transfer.plant;
  const Chunk& chunk = *transfer.chunk;
  if (transfer.cancelled || plant.closing || !demanded_recently(plant, chunk)) return true;
  if (chunk.id.kind != ChunkKind::page || chunk.id.index <= plant.decoded_page_count) return false;
  return !on_its_way(plant.chunk(ChunkKind::page, chunk.id.index - 1));
}

void Streamer::State::collect(std::uint32_t minimum) {
  const auto in_time = [&] { return minimum > 0 || options.clock_ns() < hand_over_until; };
  bool progress = true;
  while (progress) {
    progress = false;
    while (in_time()) {
      Transfer* next = completions.take();
      if (next == nullptr) break;
      Transfer& transfer = *next;
      if (minimum > 0) --minimum;
      progress = true;
      if (transfer.stage == TransferStage::reading)
        finish_read(transfer);
      else
        finish_decode(transfer);
    }
    for (const auto& plant : used_plants())
      if (plant) start_page_runs(*plant);
  }
}

void Streamer::State::collect_in_time(std::uint32_t minimum) {
  const std::uint64_t start = options.clock_ns();
  const std::uint64_t left = options.hand_over_budget_ns - std::min(options.hand_over_budget_ns, counters.hand_over_ns);
  hand_over_until = left < UINT64_MAX - start ? start + left : UINT64_MAX;
  collect(minimum);
  counters.hand_over_ns += options.clock_ns() - start;
}

void Streamer::State::finish_read(Transfer& transfer) {
  transfer.stage = TransferStage::read;
  if (transfer.bytes_read > 0) counters.bytes_read += static_cast<std::uint64_t>(transfer.bytes_read);
  if (stale(transfer)) return drop(transfer);
  if (transfer.bytes_read != static_cast<std::int64_t>(transfer.bytes.size())) return fail_read(transfer);
  if (transfer.chunk->id.kind == ChunkKind::page) return;  // start_page_runs does this, once the page before it is being loaded
  COPPICE_ASSERT(advance(*transfer.chunk, Residency::decoding));
  start_decode(transfer, hooks.jobs);
}

// A lack of memory is temporary; other failures have a few attempts. The chunk keeps its state, so chunks that follow it need not be read
// again.
void Streamer::State::fail_read(Transfer& transfer) {
  PlantStream& plant = *transfer.plant;
  const Error error = read_error(transfer.bytes_read, transfer.bytes.size(), plant.file_chunk(*transfer.chunk).offset);
  if (error.status == Status::out_of_memory) {
    out_of_memory(plant, error);
    return drop(transfer);
  }
  if (!transfer.retry.pause(options.clock_ns())) return fail(transfer, error);
  transfer.stage = TransferStage::paused;
}

void Streamer::State::retry_reads() {
  for (Transfer& transfer : transfers.span()) {
    if (transfer.stage != TransferStage::paused) continue;
    if (stale(transfer))
      drop(transfer);
    else if (options.clock_ns() >= transfer.retry.again_ns)
      start_read(transfer, transfer.plant->hooks.io, transfer.plant->io_file, transfer.plant->file_chunk(*transfer.chunk).offset);
  }
}

// One job decodes all consecutive pages that are read: otherwise a plant would gain at most one page a frame.
void Streamer::State::start_page_runs(PlantStream& plant) {
  if (plant.transfer_count == 0 || plant.decoding_page_count > 0) return;
  Transfer* first = nullptr;
  Transfer* last = nullptr;
  for (std::uint32_t page = plant.decoded_page_count; page < plant.file.plant.page_count; ++page) {
    const auto it = std::ranges::find_if(transfers.span(), [&](const Transfer& transfer) {
      return transfer.stage == TransferStage::read && transfer.chunk == &plant.chunk(ChunkKind::page, page);
    });
    if (it == transfers.span().end() || stale(*it)) break;
    if (auto prepared = prepare_page(plant, *it); !prepared) {
      out_of_memory(plant, prepared.error());
      drop(*it);
      break;
    }
    COPPICE_ASSERT(advance(*it->chunk, Residency::decoding));
    (last != nullptr ? last->next_in_run : first) = &*it;
    last = &*it;
    ++plant.decoding_page_count;
  }
  if (first != nullptr) start_decode(*first, hooks.jobs);
  for (Transfer& transfer : transfers.span())
    if (transfer.stage == TransferStage::read && transfer.plant == &plant && stale(transfer)) drop(transfer);
}

void Streamer::State::finish_decode(Transfer& transfer) {
  PlantStream& plant = *transfer.plant;
  Chunk& chunk = *transfer.chunk;
  const bool page = chunk.id.kind == ChunkKind::page;
  counters.decode_ns += transfer.decode_ns;
  if (page) --plant.decoding_page_count;
  const bool in_order = !page || chunk.id.index == plant.decoded_page_count;
  if (transfer.skipped || !in_order || stale(transfer)) return drop(transfer);
  if (transfer.outcome) accept_decoded(plant, transfer);
  if (!transfer.outcome && transfer.outcome.error().status == Status::out_of_memory) {
    out_of_memory(plant, transfer.outcome.error());
    return drop(transfer);
  }
  if (!transfer.outcome) return fail(transfer, Error(transfer.outcome.error()));
  if (page) ++plant.decoded_page_count;
  const ChunkBytes bytes = chunk_bytes(plant, chunk);
  free_transfer(transfer);
  set_bytes(chunk, bytes.gpu + bytes.kept + bytes.upload);
  COPPICE_ASSERT(advance(chunk, Residency::decoded));
}

void Streamer::State::push_request(PlantStream& plant, Chunk& chunk) {
  if (chunk.residency != Residency::absent || chunk.bytes != 0 || !demanded_now(plant, chunk)) return;
  requests.push_back({&plant, &chunk, value_of(plant, chunk)});
  std::ranges::push_heap(requests.span(), has_lower_priority);
}

// Requests the first page that is neither resident nor being loaded; none while that one has failed or is still being evicted.
void Streamer::State::push_page_request(PlantStream& plant) {
  std::uint32_t page = plant.decoded_page_count;
  while (page < plant.file.plant.page_count && on_its_way(plant.chunk(ChunkKind::page, page))) ++page;
  if (page < plant.file.plant.page_count) push_request(plant, plant.chunk(ChunkKind::page, page));
}

void Streamer::State::gather_requests() {
  requests.clear();
  for (const auto& plant : used_plants()) {
    if (!plant || plant->closing || frame_number < plant->retry_frame) continue;
    push_page_request(*plant);
    for (std::uint32_t i = plant->file.plant.page_count; i < plant->chunks.size(); ++i) push_request(*plant, plant->chunks[i]);
  }
}

Transfer* Streamer::State::free_slot() {
  const auto it = std::ranges::find(transfers.span(), TransferStage::idle, &Transfer::stage);
  return it == transfers.span().end() ? nullptr : &*it;
}

void Streamer::State::issue_requests() {
  gather_requests();
  while (!requests.empty() && free_slot() != nullptr) {
    std::ranges::pop_heap(requests.span(), has_lower_priority);
    const Request request = requests.pop_back();
    const Room room = issue(request);
    // A request of lower value must not take the memory that is being freed.
    if (room == Room::soon) break;
    if (room == Room::now && request.chunk->id.kind == ChunkKind::page) push_page_request(*request.plant);
  }
}

Room Streamer::State::issue(const Request& request) {
  PlantStream& plant = *request.plant;
  Chunk& chunk = *request.chunk;
  if (frame_number < plant.retry_frame) return Room::none;
  const std::uint64_t bytes = chunk_bytes(plant, chunk).total();
  // Some of the leaf meshes alone show nothing: they are requested once all of them fit.
  const std::uint64_t needed_bytes = in_leaf_mesh_set(plant, chunk) ? missing_leaf_mesh_bytes(plant) : bytes;
  if (const Room room = make_room(needed_bytes); room != Room::now) return room;
  // An eviction since the request was gathered may have taken the page before it.
  if (chunk.id.kind == ChunkKind::page && chunk.id.index > plant.decoded_page_count &&
      !on_its_way(plant.chunk(ChunkKind::page, chunk.id.index - 1)))
    return Room::none;
  const coppice_file_chunk& entry = plant.file_chunk(chunk);
  auto buffer = HookBuffer::allocate(hooks.allocator, static_cast<std::size_t>(entry.bytes));
  if (!buffer) {
    out_of_memory(plant, buffer.error());
    return Room::none;
  }
  Transfer& transfer = *free_slot();
  transfer.plant = &plant;
  transfer.chunk = &chunk;
  transfer.bytes = *std::move(buffer);
  ++plant.transfer_count;
  set_bytes(chunk, bytes);
  COPPICE_ASSERT(advance(chunk, Residency::reading));
  start_read(transfer, plant.hooks.io, plant.io_file, entry.offset);
  return Room::now;
}

}  // namespace coppice
