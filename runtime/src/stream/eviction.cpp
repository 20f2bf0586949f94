#include "eviction.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "check.h"

namespace coppice {

namespace {

constexpr std::size_t kMaxEvictionsAtOnce = 64;

/// Which chunks are candidates. idle: without demand in the last frames; any: all that are not pinned.
enum class Candidates : std::uint8_t { idle, any };

bool may_evict(const PlantStream& plant, const Chunk& chunk, Candidates candidates) {
  return !chunk.pinned && !chunk.eviction_planned && !chunk.pending &&
         (chunk.residency == Residency::decoded || chunk.residency == Residency::resident) &&
         (candidates == Candidates::any || !demanded_recently(plant, chunk));
}

void start_planning(const PlantSet& plants) {
  for (const auto& plant : plants.used())
    if (plant) plant->eviction_page_end = plant->decoding_page_count > 0 ? 0 : plant->decoded_page_count;
}

/// Returns the next chunk to evict. Idle chunks come before those in demand, lower values before higher ones; of
/// equal ones the plant of the lowest index, its page before its other chunks. Among a plant's pages only the last one that is not chosen
/// yet is a candidate.
ValuedChunk least_valuable(const PlantSet& plants, const CurrentFrame& frame, Candidates candidates) {
  ValuedChunk lowest{.value = std::numeric_limits<float>::infinity()};
  bool lowest_is_demanded = true;
  const auto consider = [&](PlantStream& plant, Chunk& chunk) {
    if (!may_evict(plant, chunk, candidates)) return;
    const bool is_demanded = demanded_recently(plant, chunk);
    const float value = chunk_value(plant, chunk, frame);
    if (is_demanded != lowest_is_demanded ? is_demanded : !(value < lowest.value)) return;
    lowest = {&plant, &chunk, value};
    lowest_is_demanded = is_demanded;
  };
  for_each_open(plants, [&](PlantStream& plant) {
    if (plant.eviction_page_end > 0) consider(plant, plant.chunk(ChunkKind::page, plant.eviction_page_end - 1));
    for (Chunk& chunk : plant.other_chunks()) consider(plant, chunk);
  });
  if (lowest.chunk != nullptr && lowest.chunk->id.kind == ChunkKind::page) --lowest.plant->eviction_page_end;
  return lowest;
}

/// Bytes of idle chunks that can be evicted, in however many frames.
std::uint64_t idle_bytes(const PlantSet& plants) {
  std::uint64_t bytes = 0;
  for_each_open(plants, [&](const PlantStream& plant) {
    for (std::uint32_t end = plant.eviction_page_end; end > 0; --end) {
      const Chunk& page = plant.chunk(ChunkKind::page, end - 1);
      if (!may_evict(plant, page, Candidates::idle)) break;
      bytes += page.bytes;
    }
    for (const Chunk& chunk : plant.other_chunks())
      if (may_evict(plant, chunk, Candidates::idle)) bytes += chunk.bytes;
  });
  return bytes;
}

}  // namespace

Room make_room(Evictions& evictions, Budget& budget, const PlantSet& plants, const CurrentFrame& frame, std::uint64_t bytes) {
  const std::uint64_t limit = limit_bytes(budget, plants);
  if (budget.ledger.reserved() + bytes <= limit) return Room::now;
  if (floor_bytes(budget, plants) + bytes > limit) return Room::none;
  std::array<ValuedChunk, kMaxEvictionsAtOnce> planned{};
  std::size_t count = 0;
  std::uint64_t planned_bytes = 0;
  start_planning(plants);
  while (budget.remaining_bytes(planned_bytes) + bytes > limit && count < planned.size()) {
    const ValuedChunk candidate = least_valuable(plants, frame, Candidates::idle);
    if (candidate.chunk == nullptr) break;
    planned[count++] = candidate;
    candidate.chunk->eviction_planned = true;
    planned_bytes += candidate.chunk->bytes;
  }
  // Nothing is evicted for a request that would not fit even then. If it needs more candidates than are chosen at once, the rest follows.
  const std::uint64_t later_bytes = count == planned.size() ? idle_bytes(plants) : 0;
  const bool enough = budget.remaining_bytes(planned_bytes + later_bytes) + bytes <= limit;
  for (const ValuedChunk& each : std::span(planned).first(count)) {
    each.chunk->eviction_planned = false;
    if (enough && !evictions.evicted.full()) evict(evictions, budget, frame, *each.plant, *each.chunk);
  }
  if (budget.ledger.reserved() + bytes <= limit) return Room::now;
  return enough ? Room::soon : Room::none;
}

void evict_down_to(std::uint64_t limit, Evictions& evictions, Budget& budget, const PlantSet& plants, const CurrentFrame& frame) {
  start_planning(plants);
  while (budget.remaining_bytes() > limit && !evictions.evicted.full()) {
    const ValuedChunk candidate = least_valuable(plants, frame, Candidates::any);
    if (candidate.chunk == nullptr) break;
    evict(evictions, budget, frame, *candidate.plant, *candidate.chunk);
  }
}

void evict(Evictions& evictions, Budget& budget, const CurrentFrame& frame, PlantStream& plant, Chunk& chunk) {
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
  set_bytes(budget, chunk, uploaded ? gpu_bytes : 0, uploaded ? gpu_bytes : 0);
  if (!uploaded) return;
  budget.coming_bytes += gpu_bytes;
  ++plant.evicting_count;
  ++evictions.counts[static_cast<std::size_t>(chunk.id.kind)];
  chunk.last_used_frame = frame.last_number;
  chunk.next_evicting = nullptr;
  (evictions.last != nullptr ? evictions.last->next_evicting : evictions.first) = &chunk;
  evictions.last = &chunk;
  evictions.evicted.push_back(chunk.id);
}

void release_evicted(Evictions& evictions, Budget& budget, const PlantSet& plants, const CurrentFrame& frame) {
  BoundedList<ChunkId>& released = evictions.released;
  released.clear();
  Chunk** link = &evictions.first;
  Chunk* last_kept = nullptr;
  while (*link != nullptr && (*link)->last_used_frame <= frame.completed_number && released.count < released.items.size()) {
    Chunk& chunk = **link;
    if (chunk.pending) {
      last_kept = &chunk;
      link = &chunk.next_evicting;
      continue;
    }
    *link = std::exchange(chunk.next_evicting, nullptr);
    budget.coming_bytes -= chunk.bytes;
    set_bytes(budget, chunk, 0);
    --plants.at(chunk.id.plant).evicting_count;
    COPPICE_ASSERT(advance(chunk, Residency::absent));
    released.push_back(chunk.id);
  }
  if (*link == nullptr) evictions.last = last_kept;
}

}  // namespace coppice
