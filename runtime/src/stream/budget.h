#pragma once

// The memory of open plants. A request reserves the peak memory of its chunk and releases parts as the chunk moves on. An evicted chunk
// stays reserved until the GPU has finished the frames that may read it.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "ledger.h"
#include "plant_stream.h"

namespace coppice {

/// The open plants, by index.
struct PlantSet {
  HookArray<std::unique_ptr<PlantStream>> all;  ///< grows to max_plants; null: not open
  std::uint32_t end = 0;                        ///< plants from here on were never open

  [[nodiscard]] std::span<const std::unique_ptr<PlantStream>> used() const { return all.span().first(end); }
  /// plant: open (asserted)
  [[nodiscard]] PlantStream& at(std::uint32_t plant) const;
};

/// Calls use(plant) for each plant that is open and not closing, in the order of their indices.
template <class Use>
void for_each_open(const PlantSet& plants, const Use& use) {
  for (const auto& plant : plants.used())
    if (plant && !plant->closing) use(*plant);
}

/// The memory of chunks, which is reserved from the ledger.
struct Budget {
  Ledger& ledger;
  GpuSizes gpu;
  std::uint64_t movable_bytes = 0;  ///< bytes of chunks that are not pinned
  std::uint64_t coming_bytes = 0;   ///< reserved bytes that become free without an eviction: of evicted chunks and of cancelled reads

  /// Reserved bytes without those that become free, and without `also_bytes`.
  [[nodiscard]] std::uint64_t remaining_bytes(std::uint64_t also_bytes = 0) const {
    return ledger.reserved() - std::min(ledger.reserved(), coming_bytes + also_bytes);
  }
};

/// backend_bytes: the part that is in the backend's memory
void set_bytes(Budget& budget, Chunk& chunk, std::uint64_t bytes, std::uint64_t backend_bytes = 0);
/// Frees the memory of pages that have been dropped, unless a job may read it.
void trim(Budget& budget, PlantStream& plant);
/// Bytes that no eviction frees: the open plants' tables and pinned chunks, and what other modules have reserved.
[[nodiscard]] std::uint64_t floor_bytes(const Budget& budget, const PlantSet& plants);
/// Bytes that may be reserved in all: the budget minus the bytes refused lately (if they can be freed at all), but at least minus
/// slack_bytes.
[[nodiscard]] std::uint64_t limit_bytes(const Budget& budget, const PlantSet& plants);
/// The error for bytes that the ledger has refused. It names the budget that they need.
[[nodiscard]] Error refusal(const Budget& budget, const PlantSet& plants, std::uint64_t bytes);

}  // namespace coppice
