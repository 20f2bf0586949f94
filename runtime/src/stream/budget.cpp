#include "budget.h"

#include <algorithm>
#include <string>

#include "check.h"

namespace coppice {

namespace {

/// True if the bytes would be free without every chunk that may be evicted.
bool can_be_free(const Budget& budget, const PlantSet& plants, std::uint64_t bytes) {
  return floor_bytes(budget, plants) + bytes <= budget.ledger.budget();
}

}  // namespace

PlantStream& PlantSet::at(std::uint32_t plant) const {
  COPPICE_ASSERT(plant < all.size() && all[plant] != nullptr);
  return *all[plant];
}

void set_bytes(Budget& budget, Chunk& chunk, std::uint64_t bytes, std::uint64_t backend_bytes) {
  budget.ledger.release(chunk.reserved_bytes);
  if (!chunk.pinned) budget.movable_bytes += bytes - chunk.bytes;
  chunk.bytes = bytes;
  chunk.reserved_bytes = bytes - backend_bytes + budget.gpu.form->reserved_bytes(backend_bytes);
  budget.ledger.reserve(chunk.reserved_bytes);
}

// A job that decodes a later page reads the nodes of earlier ones, so their memory is freed only when no job runs for the plant.
void trim(Budget& budget, PlantStream& plant) {
  if (!plant.trim_needed || plant.decoding_page_count > 0) return;
  for (std::uint32_t page = plant.decoded_page_count; page < plant.file.plant.page_count; ++page) {
    Chunk& chunk = plant.chunk(ChunkKind::page, page);
    if (chunk.residency != Residency::absent && chunk.residency != Residency::failed) continue;
    if (chunk.bytes == 0 && plant.page_nodes[page] == nullptr) continue;
    free_page(plant, page);
    set_bytes(budget, chunk, 0);
  }
  plant.trim_needed = false;
}

std::uint64_t floor_bytes(const Budget& budget, const PlantSet& plants) {
  std::uint64_t freed_bytes = budget.movable_bytes;
  for (const auto& plant : plants.used()) {
    if (!plant || !plant->closing) continue;
    freed_bytes += plant->base_bytes;
    for (const Chunk& chunk : plant->chunks.span())
      if (chunk.pinned) freed_bytes += chunk.bytes;
  }
  return budget.ledger.reserved() - std::min(budget.ledger.reserved(), freed_bytes);
}

std::uint64_t limit_bytes(const Budget& budget, const PlantSet& plants) {
  const std::uint64_t refused = budget.ledger.refused();
  const std::uint64_t kept_free = std::max(can_be_free(budget, plants, refused) ? refused : 0, budget.gpu.slack_bytes);
  return budget.ledger.budget() - std::min(budget.ledger.budget(), kept_free);
}

Error refusal(const Budget& budget, const PlantSet& plants, std::uint64_t bytes) {
  if (can_be_free(budget, plants, bytes))
    return {Status::out_of_memory, "memory budget: no room now; some is being made, try again in a few frames"};
  const std::uint64_t needed = floor_bytes(budget, plants) + bytes;
  return {Status::out_of_memory, "memory budget: too small whatever is freed; it must be at least, bytes", Error::kNoOffset,
          std::to_string(needed)};
}

}  // namespace coppice
