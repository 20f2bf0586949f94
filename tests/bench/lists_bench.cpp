// The rasteriser's list of every leaf of a plant, built anew: what a page that arrives costs a job.

#include <benchmark/benchmark.h>

#include "convert.h"
#include "leaf_lists.h"
#include "page_spans.h"
#include "random_tree.h"
#include "renderer_scene.h"

namespace {

using namespace coppice;

void build_list(benchmark::State& state) {
  const auto leaf_count = static_cast<std::uint32_t>(state.range(0));
  const test::DecodedPlant plant = test::decoded_plant(test::random_plant({.leaf_count = leaf_count, .seed = 1}));
  const auto pages = test::page_spans(plant.nodes);
  const std::vector<gpu::RasterCard> looks(plant.file.cards.size());
  const gpu::CrownLight light;
  const gpu::LeafSource source{plant.nodes[0], pages, looks, gpu::leaf_box(gpu::gpu_plant(plant.file.plant)), light, leaf_count};
  for (auto _ : state) {
    gpu::BuiltList list = gpu::build_leaf_list(source, leaf_count);
    if (list.leaves.size() != leaf_count) state.SkipWithError("leaves are missing");
    benchmark::DoNotOptimize(list);
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * leaf_count);
}
BENCHMARK(build_list)->Arg(1 << 12)->Arg(1 << 16)->Unit(benchmark::kMillisecond);

}  // namespace
