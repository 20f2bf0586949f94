// libFuzzer: any bytes are refused or decode as a density map, the same whatever was in the memory that it lies in, and plants scatter by
// it over the square or are told why they cannot.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "check.h"
#include "fresh_memory.h"
#include "scene_scatter.h"

namespace {

using coppice::bake::DensityMap;

void check_scatter(const DensityMap& map) {
  coppice::bake::ScatterSpecies species;
  species.density = &map;
  coppice::bake::ScatterOptions options;
  options.size_m = 100.0f;
  options.count = 20;
  const auto plants = coppice::bake::scatter_plants({&species, 1}, options);
  if (!plants) {
    COPPICE_ASSERT(plants.error().status == coppice::Status::invalid_argument);
    return;
  }
  COPPICE_ASSERT(plants->size() == options.count);
  for (const coppice::bake::ScenePlant& plant : *plants) {
    COPPICE_ASSERT(std::abs(plant.position_m[0]) <= 50.0f && std::abs(plant.position_m[2]) <= 50.0f && plant.position_m[1] == 0.0f);
    COPPICE_ASSERT(plant.scale >= options.scale_min && plant.scale <= options.scale_max && plant.species == 0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::test::fill_fresh_memory(0x55);
  const auto map = coppice::bake::decode_density_map({data, size});
  coppice::test::fill_fresh_memory(0xc3);
  const auto again = coppice::bake::decode_density_map({data, size});
  COPPICE_ASSERT(bool(map) == bool(again));
  if (!map) {
    COPPICE_ASSERT(!map.error().message().empty());
    return 0;
  }
  COPPICE_ASSERT(map->width > 0 && map->height > 0 && map->grey.size() == std::size_t{map->width} * map->height);
  COPPICE_ASSERT(map->width == again->width && map->height == again->height);
  COPPICE_ASSERT(map->grey == again->grey);
  if (map->grey.size() <= 1u << 15) check_scatter(*map);
  return 0;
}
