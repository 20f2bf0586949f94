// Memory and eviction. A request reserves the peak memory of its chunk, and releases parts as the chunk moves on; uploaded data is counted
// by device memory. An evicted chunk stays reserved until the GPU has finished the frames that may read it.

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "check.h"
#include "streamer_state.h"

namespace coppice {

namespace {

constexpr std::size_t kMaxEvictionsAtOnce = 64;

bool holds_memory(const Chunk& chunk) {
  return chunk.residency == Residency::decoded || chunk.residency == Residency::resident;
}

std::uint64_t less(std::uint64_t a, std::uint64_t b) {
  return a > b ? a - b : 0;
}

}  // namespace

void Streamer::State::set_bytes(Chunk& chunk, std::uint64_t bytes, std::uint64_t device_bytes) {
  ledger.release(chunk.reserved_bytes);
  if (!chunk.pinned) movable_bytes += bytes - chunk.bytes;
  chunk.bytes = bytes;
  chunk.reserved_bytes = options.gpu.host ? bytes : bytes - device_bytes;
  ledger.reserve(chunk.reserved_bytes);
}

std::uint64_t Streamer::State::floor_bytes() const {
  std::uint64_t leaving = 0;
  for (const auto& plant : used_plants()) {
    if (!plant || !plant->closing) continue;
    leaving += plant->base_bytes;
    for (const Chunk& chunk : plant->chunks.span())
      if (chunk.pinned) leaving += chunk.bytes;
  }
  return less(ledger.reserved(), movable_bytes + leaving);
}

std::uint64_t Streamer::State::limit_bytes() const {
  const std::uint64_t refused = can_be_free(ledger.refused()) ? ledger.refused() : 0;
  return less(ledger.budget(), std::max(refused, options.gpu.slack_bytes));
}

Error Streamer::State::refusal(std::uint64_t bytes) const {
  if (can_be_free(bytes)) return {Status::out_of_memory, "memory budget: no room now; some is being made, try again in a few frames"};
  return {Status::out_of_memory, "memory budget: needs more than all there is to free, bytes", Error::kNoOffset, std::to_string(bytes)};
}

float Streamer::State::value_of(PlantStream& plant, Chunk& chunk) {
  if (chunk.value_frame == frame_number) return chunk.value;
  chunk.value = chunk_value(plant, chunk, views);
  chunk.value_frame = frame_number;
  return chunk.value;
}

bool Streamer::State::may_evict(const PlantStream& plant, const Chunk& chunk, EvictionCandidates candidates) {
  return !chunk.pinned && !chunk.eviction_planned && !chunk.pending && holds_memory(chunk) &&
         (candidates == EvictionCandidates::any || !demanded_recently(plant, chunk));
}

// Among a plant's pages only the last one that is not chosen yet is a candidate.
Chunk* Streamer::State::least_valuable_candidate(EvictionCandidates candidates) {
  Chunk* lowest = nullptr;
  float lowest_value = std::numeric_limits<float>::infinity();
  bool lowest_is_demanded = true;
  const auto consider = [&](PlantStream& plant, Chunk& chunk) {
    if (!may_evict(plant, chunk, candidates)) return;
    const bool is_demanded = demanded_recently(plant, chunk);
    const float value = value_of(plant, chunk);
    if (is_demanded != lowest_is_demanded ? is_demanded : !(value < lowest_value)) return;
    lowest = &chunk;
    lowest_value = value;
    lowest_is_demanded = is_demanded;
  };
  for (const auto& plant : used_plants()) {
    if (!plant || plant->closing) continue;
    if (plant->decoding_page_count == 0 && plant->eviction_page_end > 0)
      consider(*plant, plant->chunk(ChunkKind::page, plant->eviction_page_end - 1));
    for (std::uint32_t i = plant->file.plant.page_count; i < plant->chunks.size(); ++i) consider(*plant, plant->chunks[i]);
  }
  return lowest;
}

std::uint64_t Streamer::State::idle_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& plant : used_plants()) {
    if (!plant || plant->closing) continue;
    for (std::uint32_t end = plant->decoding_page_count > 0 ? 0 : plant->eviction_page_end; end > 0; --end) {
      const Chunk& page = plant->chunk(ChunkKind::page, end - 1);
      if (!may_evict(*plant, page, EvictionCandidates::idle)) break;
      bytes += page.bytes;
    }
    for (std::uint32_t i = plant->file.plant.page_count; i < plant->chunks.size(); ++i)
      if (may_evict(*plant, plant->chunks[i], EvictionCandidates::idle)) bytes += plant->chunks[i].bytes;
  }
  return bytes;
}

Room Streamer::State::make_room(std::uint64_t bytes) {
  const std::uint64_t limit = limit_bytes();
  if (ledger.reserved() + bytes <= limit) return Room::now;
  if (floor_bytes() + bytes > limit) return Room::none;
  std::uint64_t coming = evicting_bytes + cancelled_bytes;
  std::array<Chunk*, kMaxEvictionsAtOnce> planned{};
  std::size_t count = 0;
  for (const auto& plant : used_plants())
    if (plant) plant->eviction_page_end = plant->decoded_page_count;
  while (less(ledger.reserved(), coming) + bytes > limit && count < planned.size()) {
    Chunk* candidate = least_valuable_candidate(EvictionCandidates::idle);
    if (candidate == nullptr) break;
    planned[count++] = candidate;
    candidate->eviction_planned = true;
    coming += candidate->bytes;
    if (candidate->id.kind == ChunkKind::page) --plants[candidate->id.plant]->eviction_page_end;
  }
  // Nothing is evicted for a request that would not fit even then. If it needs more candidates than are chosen at once, the rest follows.
  const std::uint64_t later = count == planned.size() ? idle_bytes() : 0;
  const bool enough = less(ledger.reserved(), coming + later) + bytes <= limit;
  for (std::size_t i = 0; i < count; ++i) {
    planned[i]->eviction_planned = false;
    if (enough && !evicted.full()) evict(*planned[i]);
  }
  if (ledger.reserved() + bytes <= limit) return Room::now;
  return enough ? Room::soon : Room::none;
}

void Streamer::State::enforce_budget() {
  const std::uint64_t limit = limit_bytes();
  if (less(ledger.reserved(), evicting_bytes + cancelled_bytes) <= limit) return;
  for (Transfer& transfer : transfers.span()) {
    if (transfer.stage == TransferStage::idle || transfer.stage == TransferStage::decoding || transfer.cancelled) continue;
    if (transfer.stage == TransferStage::read || transfer.stage == TransferStage::paused) {
      drop(transfer);
      continue;
    }
    transfer.cancelled = true;
    set_bytes(*transfer.chunk, transfer.bytes.size());  // the hook still writes to it
    cancelled_bytes += transfer.bytes.size();
  }
  for (const auto& plant : used_plants())
    if (plant) plant->eviction_page_end = plant->decoded_page_count;
  while (less(ledger.reserved(), evicting_bytes + cancelled_bytes) > limit && !evicted.full()) {
    Chunk* candidate = least_valuable_candidate(EvictionCandidates::any);
    if (candidate == nullptr) break;
    if (candidate->id.kind == ChunkKind::page) --plants[candidate->id.plant]->eviction_page_end;
    evict(*candidate);
  }
}

void Streamer::State::evict(Chunk& chunk) {
  PlantStream& plant = *plants[chunk.id.plant];
  const bool uploaded = chunk.residency == Residency::resident;
  const std::uint64_t gpu_bytes = chunk_bytes(plant, chunk).gpu;
  if (chunk.id.kind == ChunkKind::page) {
    COPPICE_ASSERT(chunk.id.index + 1 == plant.decoded_page_count && plant.decoding_page_count == 0);
    plant.decoded_page_count = chunk.id.index;
    plant.resident_page_count = std::min(plant.resident_page_count, plant.decoded_page_count);
    free_page(plant, chunk.id.index);
  } else {
    free_decoded(plant, chunk.id);
  }
  COPPICE_ASSERT(advance(chunk, uploaded ? Residency::evicting : Residency::absent));
  set_bytes(chunk, uploaded ? gpu_bytes : 0, uploaded ? gpu_bytes : 0);
  if (!uploaded) return;
  evicting_bytes += gpu_bytes;
  ++plant.evicting_count;
  ++counts_of(chunk).evicted;
  chunk.last_used_frame = last_frame_number;
  chunk.pending = options.gpu.host;
  chunk.next_evicting = nullptr;
  (last_evicting != nullptr ? last_evicting->next_evicting : first_evicting) = &chunk;
  last_evicting = &chunk;
  evicted.add(chunk.id);
}

// Releases in order of eviction, except chunks that a host has not freed yet.
void Streamer::State::release_evicted() {
  Chunk** link = &first_evicting;
  Chunk* last_kept = nullptr;
  while (*link != nullptr && (*link)->last_used_frame <= completed_number && released.count < released.items.size()) {
    Chunk& chunk = **link;
    if (chunk.pending) {
      last_kept = &chunk;
      link = &chunk.next_evicting;
      continue;
    }
    *link = std::exchange(chunk.next_evicting, nullptr);
    evicting_bytes -= chunk.bytes;
    set_bytes(chunk, 0);
    --plants[chunk.id.plant]->evicting_count;
    COPPICE_ASSERT(advance(chunk, Residency::absent));
    released.push_back(chunk.id);
  }
  if (*link == nullptr) last_evicting = last_kept;
}

}  // namespace coppice
