#include "plant_cost.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "atomic_file.h"
#include "gltf_document.h"

namespace coppice::bake {

namespace fs = std::filesystem;

InputCounts count_input(const fs::path& input, const ImportOptions& options) {
  InputCounts counts{0, bytes_of_file(input), {}};
  auto outline = outline_gltf(input, options.max_source_triangles);
  if (!outline) return counts;
  counts.triangles = outline->triangles;
  counts.files = std::move(outline->files);
  for (const GltfReference& reference : outline->references) {
    const auto file = resolve_reference(input.parent_path(), reference.uri, reference.place(), options.outside_files);
    if (file) counts.bytes += std::min(bytes_of_file(*file), reference.used_bytes);
  }
  return counts;
}

PlantCost plant_cost(const InputCounts& counts, const BakeOptions& options) {
  // A collapse looks at the plant from all views, at every step: its time goes by their pixels, and by how many of them leaves cover, which
  // no JSON tells; where leaves overlap more the baker makes views smaller. The rest goes by triangles and bytes.
  constexpr double kSecondsOnce = 3.0, kSecondsPerMegapixel = 10.0, kSecondsPerMillionTriangles = 50.0, kMemoryOnce = 60e6,
                   kMemoryPerInputByte = 12.0, kMemoryPerViewPixel = 100.0, kMemoryPerTriangle = 400.0;
  const std::uint32_t views = options.view_count > 0 ? options.view_count : metric_view_count(options.metric, 0);
  const double pixels = static_cast<double>(views) * options.collapse.resolution_px * options.collapse.resolution_px;
  const double triangles = static_cast<double>(counts.triangles), bytes = static_cast<double>(counts.bytes);
  const double seconds = kSecondsOnce + kSecondsPerMegapixel * pixels / 1e6 + kSecondsPerMillionTriangles * triangles / 1e6;
  const double memory = kMemoryOnce + kMemoryPerInputByte * bytes + kMemoryPerViewPixel * pixels + kMemoryPerTriangle * triangles;
  return {static_cast<std::uint64_t>(1000.0 * seconds), static_cast<std::uint64_t>(memory)};
}

std::vector<std::uint32_t> slowest_first(std::span<const PlantCost> costs) {
  std::vector<std::uint32_t> order(costs.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return costs[a].milliseconds != costs[b].milliseconds ? costs[a].milliseconds > costs[b].milliseconds : a < b;
  });
  return order;
}

double done_fraction(std::span<const PlantCost> costs, std::span<const double> done) {
  double all_ms = 0.0, done_ms = 0.0;
  for (std::size_t plant = 0; plant < costs.size(); ++plant) {
    const double cost_ms = 1.0 + static_cast<double>(costs[plant].milliseconds);
    all_ms += cost_ms;
    done_ms += cost_ms * done[plant];
  }
  return all_ms > 0.0 ? done_ms / all_ms : 1.0;
}

std::vector<PlantGroup> plan_tasks(std::span<const PlantCost> costs, const TaskPlan& plan) {
  const std::vector<std::uint32_t> order = slowest_first(costs);
  std::uint64_t left_ms = 0;
  for (const PlantCost& cost : costs) left_ms += cost.milliseconds;
  std::vector<PlantGroup> tasks;
  for (std::size_t at = 0; at < order.size();) {
    // The last tasks that there may be take all that is left.
    const std::uint64_t tasks_left = plan.max_tasks > tasks.size() ? plan.max_tasks - tasks.size() : 1;
    const std::uint64_t share_ms = std::clamp(left_ms / (2 * std::uint64_t{plan.slots}), plan.min_task_ms, plan.max_task_ms);
    const std::uint64_t target_ms = std::max(share_ms, left_ms / tasks_left);
    PlantGroup task;
    std::uint64_t task_ms = 0;
    do {
      task_ms += costs[order[at]].milliseconds;
      task.push_back(order[at++]);
    } while (at < order.size() && task_ms + costs[order[at]].milliseconds <= target_ms);
    left_ms -= task_ms;
    tasks.push_back(std::move(task));
  }
  return tasks;
}

std::vector<PlantGroup> plan_shards(std::span<const PlantCost> costs, std::uint32_t count) {
  std::vector<PlantGroup> shards(count);
  std::vector<std::uint64_t> shard_ms(count, 0);
  for (const std::uint32_t plant : slowest_first(costs)) {
    const auto least = static_cast<std::size_t>(std::ranges::min_element(shard_ms) - shard_ms.begin());
    shard_ms[least] += costs[plant].milliseconds;
    shards[least].push_back(plant);
  }
  for (PlantGroup& shard : shards) std::ranges::sort(shard);
  return shards;
}

}  // namespace coppice::bake
