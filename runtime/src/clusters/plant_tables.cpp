#include "plant_tables.h"

#include <algorithm>
#include <utility>

#include "coppice_shared.h"
#include "crown_light.h"
#include "page_clusters.h"

namespace coppice::gpu {

PlantTables place_plant_tables(const PlantFile& file) {
  PlantTables tables;
  const auto place = [&](std::uint64_t bytes) { return std::exchange(tables.bytes, (tables.bytes + bytes + 15) / 16 * 16); };
  tables.cards_at = place(file.cards.size() * sizeof(Card));
  tables.materials_at = place(file.materials.size() * sizeof(Material));
  tables.looks_at = place((file.cards.size() + file.materials.size()) * sizeof(CardLook));
  tables.crown_at = place(sizeof CrownLight::words);
  tables.pages_at = place(std::max<std::uint64_t>(file.plant.page_count, 1) * sizeof(uvec2));
  tables.lists_at = place(kClusterLists * sizeof(ClusterList));
  tables.cuts_at = place(ready_cut_bytes(file.plant.leaf_count));
  return tables;
}

}  // namespace coppice::gpu
