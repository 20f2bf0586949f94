#pragma once

// Evictions: which chunks go when memory is short, and when the GPU is done with them.

#include <array>
#include <cstdint>

#include "bounded_list.h"
#include "budget.h"

namespace coppice {

struct Evictions {
  Chunk* first = nullptr;  ///< chunks that the GPU may still read, in order of eviction
  Chunk* last = nullptr;
  BoundedList<ChunkId> evicted;                         ///< those that have not been handed out
  BoundedList<ChunkId> released;                        ///< those of the last release_evicted
  std::array<std::uint64_t, kChunkKindCount> counts{};  ///< evicted ones since the beginning, by kind
};

/// Whether memory is available for a request.
enum class Room : std::uint8_t {
  now,
  soon,  ///< once the GPU is done with evicted chunks, or a cancelled read returns
  none,  ///< all memory holds chunks in demand
};

/// Tells whether `bytes` more fit. If not, starts to evict chunks without demand, provided that the bytes then fit.
Room make_room(Evictions& evictions, Budget& budget, const PlantSet& plants, const CurrentFrame& frame, std::uint64_t bytes);
/// Evicts chunks that are not pinned, those without demand first, until no more than `limit` bytes remain.
void evict_down_to(std::uint64_t limit, Evictions& evictions, Budget& budget, const PlantSet& plants, const CurrentFrame& frame);
/// chunk: decoded or resident; the last decoded page of its plant, if it is a page. before: evictions.evicted is not full
void evict(Evictions& evictions, Budget& budget, const CurrentFrame& frame, PlantStream& plant, Chunk& chunk);
/// Releases chunks that the GPU is done with, in order of eviction, except those that a host has not freed yet.
void release_evicted(Evictions& evictions, Budget& budget, const PlantSet& plants, const CurrentFrame& frame);

}  // namespace coppice
