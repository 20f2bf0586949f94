// A page of a plant made into clusters: what a page that arrives costs a job beside decoding.

#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "card_looks.h"
#include "convert.h"
#include "page_clusters.h"
#include "random_tree.h"
#include "renderer_scene.h"

namespace {

using namespace coppice;

void build_pages(benchmark::State& state) {
  const auto leaf_count = static_cast<std::uint32_t>(state.range(0));
  const test::DecodedPlant plant = test::decoded_plant(test::random_plant({.leaf_count = leaf_count, .seed = 1}));
  const gpu::PlantLooks looks = *gpu::plant_looks(plant.file, default_allocator());
  const gpu::LeafBox box = gpu::leaf_box(gpu::gpu_plant(plant.file.plant));
  const auto page_nodes = [&](std::size_t page) {
    const std::size_t first = page * gpu::kPageNodes + 1;
    return std::span(plant.nodes).subspan(first, std::min<std::size_t>(gpu::kPageNodes, plant.nodes.size() - first));
  };
  const gpu::CrownLight light = gpu::measure_crown({plant.nodes[0], page_nodes(0), looks.cards(), box});
  const gpu::LeafSource source{plant.nodes[0], looks.cards(), box, &light, leaf_count};
  const auto scratch = std::make_unique<gpu::ClusterScratch>();
  std::vector<std::uint8_t> out(gpu::kPageBytes);
  for (auto _ : state)
    for (std::uint32_t page = 0; page < plant.file.plant.page_count; ++page) {
      gpu::build_page(source, page, page_nodes(page), *scratch, out);
      benchmark::DoNotOptimize(out.data());
    }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * leaf_count);
}
BENCHMARK(build_pages)->Arg(1 << 12)->Arg(1 << 16)->Unit(benchmark::kMillisecond);

}  // namespace
