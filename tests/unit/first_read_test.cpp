// What a first picture needs is one read of at most 64 KiB: of the built-in plants, and of every plant in the folder of third-party ones.
// Collapses take minutes and change only page 0: here leaves merge with neighbours in random order, which makes it longer, not shorter.

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "bounds.h"
#include "error_table.h"
#include "generate_plant.h"
#include "import_gltf.h"
#include "leaf_cards.h"
#include "packed_plant.h"
#include "plants_folder.h"
#include "reader.h"
#include "results.h"
#include "texture_regions.h"
#include "wood_lods.h"

namespace coppice::bake::first_read_test {

/// As long as measure_error_table's, and of no meaning.
ErrorTable flat_errors(std::uint32_t leaf_count) {
  constexpr std::uint32_t kLevels = 24, kSizes = 7;
  std::set<std::uint32_t> levels = {1, leaf_count};
  for (std::uint32_t level = 2; level < kLevels && level < leaf_count; ++level) levels.insert(level);
  ErrorTable errors{{levels.begin(), levels.end()}, {}, {}};
  for (std::uint32_t size = 0; size < kSizes; ++size) errors.sizes_px.push_back(static_cast<float>(8u << size));
  errors.error_px.assign(errors.leaf_counts.size() * kSizes, 0.0f);
  return errors;
}

std::uint64_t first_read_bytes(Plant plant) {
  const auto foliage = test::must(card_foliage(plant));
  BakedPlant baked;
  baked.name = plant.name;
  baked.metric = COPPICE_METRIC_IMAGE;
  baked.tree = test::random_tree(foliage, 1);
  baked.card_table = foliage.card_table;
  baked.materials = plant.materials;
  for (Material& material : baked.materials) material.image = kNone;  // no part of the first read
  baked.errors = flat_errors(foliage.leaf_count());
  baked.sphere = plant_sphere(foliage, plant.wood);
  for (const WoodLevel& level : wood_levels(plant.wood)) baked.wood.lods.push_back(level.front());
  drop_unused_materials(baked);
  const auto file = test::packed(baked);
  return read_front(file, file.size())->header.first_read_bytes;
}

TEST(FirstRead, OfABuiltInPlantIsAtMost64KiB) {
  for (const char* species : {"corylus", "willow", "juniper"})
    EXPECT_LE(first_read_bytes(*generate_plant(species, 1)), COPPICE_FIRST_READ_BYTES) << species;
}

TEST(FirstRead, OfAThirdPartyPlantIsAtMost64KiB) {
  COPPICE_PLANT_OR_SKIP(path, "");
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.path().extension() != ".glb") continue;
    auto plant = test::must(import_gltf(entry.path(), {}));
    EXPECT_LE(first_read_bytes(std::move(plant)), COPPICE_FIRST_READ_BYTES) << entry.path();
    ++count;
  }
  EXPECT_GT(count, 0u);
}

}  // namespace coppice::bake::first_read_test
