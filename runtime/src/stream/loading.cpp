#include "loading.h"

#include <algorithm>
#include <utility>

#include "check.h"

namespace coppice {

namespace {

constexpr std::uint64_t kRetryFrames = 30;

bool on_its_way(const Chunk& chunk) {
  return chunk.residency == Residency::reading || chunk.residency == Residency::decoding;
}

/// True if nobody needs the transfer any more, or a page would not continue those before it.
bool stale(const Transfer& transfer) {
  const PlantStream& plant = *transfer.plant;
  const Chunk& chunk = *transfer.chunk;
  if (transfer.cancelled || plant.closing || !demanded_recently(plant, chunk)) return true;
  if (chunk.id.kind != ChunkKind::page || chunk.id.index <= plant.decoded_page_count) return false;
  return !on_its_way(plant.chunk(ChunkKind::page, chunk.id.index - 1));
}

/// Cancels a running read.
void cancel(Transfer& transfer, Budget& budget) {
  const PlantStream& plant = *transfer.plant;
  transfer.cancelled = true;
  set_bytes(budget, *transfer.chunk, transfer.bytes.size());  // the hook still writes to it
  budget.coming_bytes += transfer.bytes.size();
  cancel_read(plant.hooks.io, plant.io_file, &transfer);
}

void free_transfer(Transfer& transfer, Budget& budget) {
  if (transfer.cancelled) budget.coming_bytes -= transfer.bytes.size();
  --transfer.plant->transfer_count;
  transfer = Transfer{.queue = transfer.queue};
}

/// Ends a transfer without a result. to: absent or failed
void end_transfer(Transfer& transfer, Budget& budget, Residency to) {
  Chunk& chunk = *transfer.chunk;
  PlantStream& plant = *transfer.plant;
  free_transfer(transfer, budget);
  COPPICE_ASSERT(advance(chunk, to));
  plant.trim_needed = true;
  if (chunk.id.kind != ChunkKind::page || plant.page_nodes[chunk.id.index] == nullptr) set_bytes(budget, chunk, 0);
  trim(budget, plant);
}

void drop(Loading& loading, Budget& budget, Transfer& transfer) {
  if (transfer.chunk->residency == Residency::reading) ++loading.counts_of(*transfer.chunk).cancelled;
  end_transfer(transfer, budget, Residency::absent);
}

/// again: it has failed before, and that was logged
void fail(Loading& loading, Budget& budget, Transfer& transfer, Error error, bool again = false) {
  Chunk& chunk = *transfer.chunk;
  PlantStream& plant = *transfer.plant;
  if (error.offset == Error::kNoOffset) error.offset = plant.file_chunk(chunk).offset;
  if (!again) {
    log_line(plant.hooks.log, COPPICE_LOG_ERROR, "%s: %s %u: %s", plant.path.data(), chunk_kind_name(chunk.id.kind), chunk.id.index,
             error.message().c_str());
    ++loading.counts_of(chunk).failed;
  }
  give_up(plant, chunk);
  end_transfer(transfer, budget, Residency::failed);
}

void read_chunk(Transfer& transfer) {
  const PlantStream& plant = *transfer.plant;
  start_read(transfer, plant.hooks.io, plant.io_file, plant.file_chunk(*transfer.chunk).offset);
}

// A lack of memory is temporary; other failures have a few attempts. The chunk keeps its state, so chunks that follow it need not be read
// again.
void fail_read(Loading& loading, Budget& budget, const CurrentFrame& frame, Transfer& transfer) {
  PlantStream& plant = *transfer.plant;
  const Error error = read_error(transfer.bytes_read, transfer.bytes.size(), plant.file_chunk(*transfer.chunk).offset);
  if (error.status == Status::out_of_memory) {
    pause_requests(plant, frame, error);
    return drop(loading, budget, transfer);
  }
  const bool again = transfer.chunk->unreadable;
  const std::uint64_t now = loading.clock_ns();
  if (!again && transfer.retry.pause(now)) {
    transfer.stage = TransferStage::paused;
    return;
  }
  transfer.chunk->unreadable = true;
  plant.reread.schedule(now, again);
  fail(loading, budget, transfer, error, again);
}

void finish_read(Loading& loading, Budget& budget, const CurrentFrame& frame, Transfer& transfer) {
  transfer.stage = TransferStage::read;
  if (transfer.bytes_read > 0) loading.counters.bytes_read += static_cast<std::uint64_t>(transfer.bytes_read);
  if (stale(transfer)) return drop(loading, budget, transfer);
  if (transfer.bytes_read != static_cast<std::int64_t>(transfer.bytes.size())) return fail_read(loading, budget, frame, transfer);
  transfer.chunk->unreadable = false;
  if (transfer.chunk->id.kind == ChunkKind::page) return;  // start_page_run does this, once the page before it is being loaded
  COPPICE_ASSERT(advance(*transfer.chunk, Residency::decoding));
  start_decode(transfer, transfer.plant->hooks.jobs, COPPICE_PRIORITY_NORMAL);
}

void finish_decode(Loading& loading, Budget& budget, const CurrentFrame& frame, Transfer& transfer) {
  PlantStream& plant = *transfer.plant;
  Chunk& chunk = *transfer.chunk;
  const bool page = chunk.id.kind == ChunkKind::page;
  loading.counters.decode_ns += transfer.decode_ns;
  if (page) --plant.decoding_page_count;
  const bool in_order = !page || chunk.id.index == plant.decoded_page_count;
  if (transfer.skipped || !in_order || stale(transfer)) return drop(loading, budget, transfer);
  if (!transfer.outcome && transfer.outcome.error().status == Status::out_of_memory) {
    pause_requests(plant, frame, transfer.outcome.error());
    return drop(loading, budget, transfer);
  }
  if (!transfer.outcome) return fail(loading, budget, transfer, transfer.outcome.error());
  accept_decoded(plant, transfer);
  if (page) ++plant.decoded_page_count;
  const ChunkBytes bytes = chunk_bytes(plant, chunk);
  free_transfer(transfer, budget);
  set_bytes(budget, chunk, bytes.gpu + bytes.kept + bytes.upload);
  COPPICE_ASSERT(advance(chunk, Residency::decoded));
}

// One job decodes all consecutive pages that are read: otherwise a plant would gain at most one page a frame.
void start_page_run(Loading& loading, Budget& budget, const CurrentFrame& frame, PlantStream& plant) {
  if (plant.transfer_count == 0 || plant.decoding_page_count > 0) return;
  const std::span<Transfer> transfers = loading.transfers.span();
  Transfer* first = nullptr;
  Transfer* last = nullptr;
  for (std::uint32_t page = plant.decoded_page_count; page < plant.file.plant.page_count; ++page) {
    const auto it = std::ranges::find_if(transfers, [&](const Transfer& transfer) {
      return transfer.stage == TransferStage::read && transfer.chunk == &plant.chunk(ChunkKind::page, page);
    });
    if (it == transfers.end() || stale(*it)) break;
    if (auto prepared = prepare_page(plant, *it); !prepared) {
      pause_requests(plant, frame, prepared.error());
      drop(loading, budget, *it);
      break;
    }
    COPPICE_ASSERT(advance(*it->chunk, Residency::decoding));
    (last != nullptr ? last->next_in_run : first) = &*it;
    last = &*it;
    ++plant.decoding_page_count;
  }
  if (first != nullptr) start_decode(*first, plant.hooks.jobs, COPPICE_PRIORITY_NORMAL);
  for (Transfer& transfer : transfers)
    if (transfer.stage == TransferStage::read && transfer.plant == &plant && stale(transfer)) drop(loading, budget, transfer);
}

void push_request(Loading& loading, const CurrentFrame& frame, PlantStream& plant, Chunk& chunk) {
  if (chunk.residency != Residency::absent || chunk.bytes != 0 || !is_demanded(plant, plant.demanded.now, chunk)) return;
  loading.requests.push_back({&plant, &chunk, chunk_value(plant, chunk, frame)});
  std::ranges::push_heap(loading.requests.span(), has_lower_priority);
}

// Requests the first page that is neither resident nor being loaded; none while that one has failed or is still being evicted.
void push_page_request(Loading& loading, const CurrentFrame& frame, PlantStream& plant) {
  std::uint32_t page = plant.decoded_page_count;
  while (page < plant.file.plant.page_count && on_its_way(plant.chunk(ChunkKind::page, page))) ++page;
  if (page < plant.file.plant.page_count) push_request(loading, frame, plant, plant.chunk(ChunkKind::page, page));
}

void gather_requests(Loading& loading, const PlantSet& plants, const CurrentFrame& frame) {
  loading.requests.clear();
  for_each_open(plants, [&](PlantStream& plant) {
    if (frame.number < plant.retry_frame) return;
    push_page_request(loading, frame, plant);
    for (Chunk& chunk : plant.other_chunks()) push_request(loading, frame, plant, chunk);
  });
}

/// A part of begin_frame that counts as taking over reads and decodes.
class SpentTime {
 public:
  explicit SpentTime(Loading& loading) : loading_(loading), start_ns_(loading.clock_ns()) {
    const std::uint64_t left = loading.hand_over_budget_ns - std::min(loading.hand_over_budget_ns, loading.counters.hand_over_ns);
    if (left < UINT64_MAX - start_ns_) end_ns_ = start_ns_ + left;
  }
  ~SpentTime() { loading_.counters.hand_over_ns += loading_.clock_ns() - start_ns_; }
  SpentTime(const SpentTime&) = delete;
  SpentTime& operator=(const SpentTime&) = delete;
  /// True if the frame has time left.
  [[nodiscard]] bool is_left() const { return loading_.clock_ns() < end_ns_; }

 private:
  Loading& loading_;
  std::uint64_t start_ns_, end_ns_ = UINT64_MAX;
};

/// Starts the read of a chunk that fits, in a free slot. False if the allocator hook has no memory, or if an eviction since the request was
/// gathered has taken the page before it.
bool start_request(Transfer& transfer, Budget& budget, const CurrentFrame& frame, PlantStream& plant, Chunk& chunk) {
  if (chunk.id.kind == ChunkKind::page && chunk.id.index > plant.decoded_page_count &&
      !on_its_way(plant.chunk(ChunkKind::page, chunk.id.index - 1)))
    return false;
  auto buffer = HookBuffer::allocate_for_overwrite(plant.hooks.allocator, static_cast<std::size_t>(plant.file_chunk(chunk).bytes));
  if (!buffer) {
    pause_requests(plant, frame, buffer.error());
    return false;
  }
  transfer.plant = &plant;
  transfer.chunk = &chunk;
  transfer.bytes = *std::move(buffer);
  ++plant.transfer_count;
  set_bytes(budget, chunk, chunk_bytes(plant, chunk).total());
  COPPICE_ASSERT(advance(chunk, Residency::reading));
  read_chunk(transfer);
  return true;
}

}  // namespace

bool has_lower_priority(const ValuedChunk& a, const ValuedChunk& b) {
  if (a.value != b.value) return a.value < b.value;
  if (a.plant != b.plant) return a.plant->index > b.plant->index;
  if (a.chunk->id.kind != b.chunk->id.kind) return a.chunk->id.kind > b.chunk->id.kind;
  return a.chunk->id.index > b.chunk->id.index;
}

void pause_requests(PlantStream& plant, const CurrentFrame& frame, const Error& error) {
  if (frame.number >= plant.retry_frame)
    log_line(plant.hooks.log, COPPICE_LOG_WARNING, "%s: %s; stays coarse", plant.path.data(), error.message().c_str());
  plant.retry_frame = frame.number + kRetryFrames;
}

// A hook that cannot cancel goes on reading: until it is done its chunk may be in demand again.
void retry_reads(Loading& loading, Budget& budget) {
  for (Transfer& transfer : loading.transfers.span()) {
    if (transfer.stage == TransferStage::reading && transfer.plant->hooks.io.cancel != nullptr && !transfer.cancelled && stale(transfer))
      cancel(transfer, budget);
    if (transfer.stage != TransferStage::paused) continue;
    if (stale(transfer))
      drop(loading, budget, transfer);
    else if (loading.clock_ns() >= transfer.retry.again_ns)
      read_chunk(transfer);
  }
}

void retry_unreadable(const Loading& loading, const PlantSet& plants) {
  for_each_open(plants, [&](PlantStream& plant) {
    if (plant.reread.take(loading.clock_ns)) forget_failures(plant, true);
  });
}

void collect(Loading& loading, Budget& budget, const PlantSet& plants, const CurrentFrame& frame, std::uint32_t minimum) {
  const SpentTime time(loading);
  const auto in_time = [&] { return minimum > 0 || time.is_left(); };
  for (bool progress = true; progress;) {
    progress = false;
    while (in_time()) {
      Transfer* transfer = loading.completions.take();
      if (transfer == nullptr) break;
      if (minimum > 0) --minimum;
      progress = true;
      if (transfer->stage == TransferStage::reading)
        finish_read(loading, budget, frame, *transfer);
      else
        finish_decode(loading, budget, frame, *transfer);
    }
    for (const auto& plant : plants.used())
      if (plant) start_page_run(loading, budget, frame, *plant);
  }
}

void cancel_reads(Loading& loading, Budget& budget) {
  for (Transfer& transfer : loading.transfers.span()) {
    if (transfer.stage == TransferStage::read || transfer.stage == TransferStage::paused) drop(loading, budget, transfer);
    if (transfer.stage == TransferStage::reading && !transfer.cancelled) cancel(transfer, budget);
  }
}

void issue_requests(Loading& loading, Evictions& evictions, Budget& budget, const PlantSet& plants, const CurrentFrame& frame) {
  const std::span<Transfer> transfers = loading.transfers.span();
  gather_requests(loading, plants, frame);
  const SpentTime time(loading);
  for (bool first = true; !loading.requests.empty() && (std::exchange(first, false) || time.is_left());) {
    const auto slot = std::ranges::find(transfers, TransferStage::idle, &Transfer::stage);
    if (slot == transfers.end()) return;
    std::ranges::pop_heap(loading.requests.span(), has_lower_priority);
    const auto [plant, chunk, value] = loading.requests.pop_back();
    if (frame.number < plant->retry_frame) continue;
    const Room room = make_room(evictions, budget, plants, frame, chunk_bytes(*plant, *chunk).total());
    // A request of lower value must not take the memory that is being freed.
    if (room == Room::soon) return;
    if (room == Room::none || !start_request(*slot, budget, frame, *plant, *chunk)) continue;
    if (chunk->id.kind == ChunkKind::page) push_page_request(loading, frame, *plant);
  }
}

}  // namespace coppice
