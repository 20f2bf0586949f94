#pragma once

// The places of a plant's tables in its memory on the device.

#include <cstdint>

#include "reader.h"

namespace coppice::gpu {

/// Offsets, multiples of 16, of Card[cards], Material[materials], CardLook[cards + materials], words of crown light[kCrownCells^3],
/// addresses of pages[pages, at least 1], ClusterList[kClusterLists] and the ready cuts.
struct PlantTables {
  std::uint64_t cards_at = 0, materials_at = 0, looks_at = 0, crown_at = 0, pages_at = 0, lists_at = 0, cuts_at = 0;
  std::uint64_t bytes = 0;  ///< size of all tables
};

PlantTables place_plant_tables(const PlantFile& file);

}  // namespace coppice::gpu
