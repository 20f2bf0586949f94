// What the view asks of 10^4, 10^5 and 10^6 plants, 4 m apart, blocks of neighbours, seen from their middle. The sum of what was counted is
// checked: a fast wrong answer fails.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "demand.h"

namespace {

using namespace coppice;

constexpr std::uint32_t kSpecies = 4;

/// Slots of blocks of 8 x 4 plants; blocks of one species.
std::vector<InstanceSphere> plantation(std::size_t count) {
  constexpr float kStep_m = 4.0f;
  const auto row_blocks = static_cast<std::size_t>(std::sqrt(static_cast<double>(count)) / 8.0) + 1;
  const float half_m = 0.5f * kStep_m * 8.0f * static_cast<float>(row_blocks);
  std::vector<InstanceSphere> instances;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t block = i / kInstanceBlockSlots, place = i % kInstanceBlockSlots;
    const std::size_t x = block % row_blocks * 8 + place % 8, z = block / row_blocks * 4 + place / 8;
    instances.push_back({{kStep_m * static_cast<float>(x) - half_m, 2.0f, kStep_m * static_cast<float>(z) - half_m},
                         2.0f + 0.3f * static_cast<float>(i % 3),
                         static_cast<std::uint32_t>(block % kSpecies)});
  }
  return instances;
}

coppice_camera looking_ahead() {
  coppice_camera view{};
  view.width_px = 1280;
  view.height_px = 720;
  view.error_px = 2.0f;
  view.layer_mask = COPPICE_ALL_LAYERS;
  for (std::size_t i = 0; i < 4; ++i) view.view_from_world[5 * i] = 1.0f;
  view.clip_from_view[0] = 1.0f;
  view.clip_from_view[5] = -1280.0f / 720.0f;
  view.clip_from_view[11] = -1.0f;
  view.clip_from_view[14] = 0.1f;
  return view;
}

void measure(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  const std::vector<InstanceSphere> slots = plantation(count);
  std::vector<InstanceBounds> bounds;
  for (std::size_t first = 0; first < count; first += kInstanceBlockSlots)
    bounds.push_back(instance_bounds(std::span(slots).subspan(first, std::min<std::size_t>(kInstanceBlockSlots, count - first))));
  const auto view = demand_view(looking_ahead());
  std::vector<PlantDemand> demands(kSpecies);
  for (auto _ : state) {
    measure_demand({slots, bounds}, *view, demands);
    benchmark::DoNotOptimize(demands.data());
    benchmark::ClobberMemory();
  }
  double weight = 0.0;
  for (const PlantDemand& demand : demands)
    for (const float instances : demand.instances) weight += static_cast<double>(instances);
  // Half the width is as far as the distance: a quarter of the plants is in view and counts 1, the rest kOutsideWeight.
  const double share = weight / static_cast<double>(count);
  if (std::abs(share - (0.25 + 0.75 * static_cast<double>(kOutsideWeight))) > 0.05) state.SkipWithError("not the weight expected");
  state.counters["instances/s"] = benchmark::Counter(static_cast<double>(count), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(measure)->Arg(10000)->Arg(100000)->Arg(1000000)->Unit(benchmark::kMicrosecond);

}  // namespace
