// Cut selections a second on one core, for a ring of plants from 2 m to 2 km. The mean of what was selected is checked: a fast wrong
// answer fails.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "hook_array.h"
#include "select.h"

namespace {

using namespace coppice;

/// A plausible table: error falls as 1 / sqrt(m) and grows with size.
PlantFile table_file() {
  PlantFile file;
  file.plant.leaf_count = 8192;
  std::vector<std::uint32_t> leaf_counts;
  std::vector<float> sizes_px, error_px, wood_error_px;
  for (std::uint32_t m = 1; m <= 8192; m *= 2) leaf_counts.push_back(m);
  for (float size = 8.0f; size <= 512.0f; size *= 2.0f) sizes_px.push_back(size);
  for (std::uint32_t m : leaf_counts)
    for (float size : sizes_px) error_px.push_back(0.4f * size / std::sqrt(static_cast<float>(m)));
  file.plant.wood_lod_count = 4;
  for (std::uint32_t i = 0; i < 4; ++i)
    for (const float size : sizes_px) wood_error_px.push_back(0.02f * static_cast<float>(i) * size);
  file.error_leaf_counts = test::hook_array(leaf_counts);
  file.error_sizes_px = test::hook_array(sizes_px);
  file.error_px = test::hook_array(error_px);
  file.wood_error_px = test::hook_array(wood_error_px);
  return file;
}

void select_instances(benchmark::State& state) {
  const PlantFile file = table_file();
  const HookArray<std::uint32_t> words = *pack_lod_table(file, default_allocator());
  const std::vector<LodPlant> plants = {{lod_table(file, words), 8192, 0b1111}};
  std::vector<InstanceSphere> instances;
  const auto count = static_cast<std::size_t>(state.range(0));
  for (std::size_t i = 0; i < count; ++i)
    instances.push_back({{0.0f, 0.0f, -2.0f * std::pow(1000.0f, static_cast<float>(i) / static_cast<float>(count))}, 3.0f, 0});
  const LodView view{.focal_px = 700.0f, .error_px = 2.0f};
  std::vector<InstanceLod> lods(count);
  double leaves = 0.0;
  for (auto _ : state) {
    select_lods(instances, plants, view, lods);
    benchmark::DoNotOptimize(lods.data());
    benchmark::ClobberMemory();
  }
  for (const InstanceLod& lod : lods) leaves += static_cast<double>(lod.leaf_count);
  // By hand: m = (0.4 size / T)^2 = (840 / d)^2 from 1 to 8192, averaged over log d. The table interpolates, hence 5%.
  const double mean = leaves / static_cast<double>(count);
  if (std::abs(mean - 2413.0) > 120.0) state.SkipWithError("the selection's leaves are not those expected");
  state.counters["selections/s"] = benchmark::Counter(static_cast<double>(count), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["mean_leaves"] = mean;
}
BENCHMARK(select_instances)->Arg(2000)->Arg(131072);

}  // namespace
