#pragma once

// Loading: reads and decodes in flight, and requests for more. A transfer is handled when its read returns and again when its decode
// returns: it moves on, fails, or is dropped because its chunk is no longer in demand.

#include <cstdint>

#include "eviction.h"
#include "transfer.h"

namespace coppice {

struct Loading {
  std::uint64_t (*clock_ns)() = now_ns;
  std::uint64_t hand_over_budget_ns = 0;  ///< StreamerOptions'
  HookArray<Transfer> transfers;          ///< [max_in_flight]
  CompletionQueue<Transfer> completions;  ///< also those that no frame has had time for yet
  BoundedList<ValuedChunk> requests;      ///< scratch, a heap by value: at most a page and all other chunks of each plant
  StreamStats counters;                   ///< without evictions

  [[nodiscard]] ChunkCounts& counts_of(const Chunk& chunk) { return counters.chunks[static_cast<std::size_t>(chunk.id.kind)]; }
};

/// A strict order, by value.
bool has_lower_priority(const ValuedChunk& a, const ValuedChunk& b);

/// Restarts reads whose pause is over, and cancels those whose chunk is no longer in demand.
void retry_reads(Loading& loading, Budget& budget);
/// Lets chunks that no attempt could read be requested again, when it is time.
void retry_unreadable(const Loading& loading, const PlantSet& plants);
/// Takes over finished transfers until the frame's time for it is up, but at least `minimum` of them.
void collect(Loading& loading, Budget& budget, const PlantSet& plants, const CurrentFrame& frame, std::uint32_t minimum);
/// Cancels all reads: those that run end without a result.
void cancel_reads(Loading& loading, Budget& budget);
/// Starts reads of the chunks in demand, highest value first, as far as memory, slots and the frame's time go, but at least one.
void issue_requests(Loading& loading, Evictions& evictions, Budget& budget, const PlantSet& plants, const CurrentFrame& frame);

/// Logs a lack of memory, and makes no requests for the plant for some frames.
void pause_requests(PlantStream& plant, const CurrentFrame& frame, const Error& error);

}  // namespace coppice
