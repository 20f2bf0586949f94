#include "farm_plan.h"

#include <algorithm>

namespace coppice::bake {
namespace {

/// Limits come in doublings of 512 MB, so that few arrays serve all plants.
std::uint64_t memory_class(std::uint64_t memory_bytes) {
  std::uint64_t bytes = 512'000'000;
  while (bytes < memory_bytes && bytes < (std::uint64_t{1} << 60)) bytes *= 2;
  return bytes;
}

/// Gives tasks their plants, from what is left to do.
class TaskSizes {
 public:
  TaskSizes(std::span<const PlantCost> costs, const PlanOptions& options) : options_(options), tasks_left_(options.most_tasks) {
    for (const PlantCost& cost : costs) left_ms_ += cost.milliseconds;
  }
  /// What the next task should take.
  [[nodiscard]] std::uint64_t next_ms() const {
    const std::uint64_t share = left_ms_ / (2 * std::uint64_t{options_.slots});
    // Where tasks become few, each takes what none may be left of.
    const std::uint64_t least = left_ms_ / std::max(1u, tasks_left_);
    return std::max(std::clamp(share, options_.shortest_task_ms, options_.longest_task_ms), least);
  }
  void take(std::uint64_t milliseconds) {
    left_ms_ -= milliseconds;
    if (tasks_left_ > 1) --tasks_left_;
  }

 private:
  const PlanOptions& options_;
  std::uint64_t left_ms_ = 0;
  std::uint32_t tasks_left_;
};

std::vector<FarmTask> tasks_of(std::span<const std::uint32_t> order, std::span<const PlantCost> costs, TaskSizes& sizes) {
  std::vector<FarmTask> tasks;
  for (std::size_t at = 0; at < order.size();) {
    FarmTask task;
    const std::uint64_t wanted_ms = sizes.next_ms();
    std::uint64_t taken_ms = 0;
    do {
      taken_ms += costs[order[at]].milliseconds;
      task.plants.push_back(order[at++]);
    } while (at < order.size() && taken_ms + costs[order[at]].milliseconds <= wanted_ms);
    sizes.take(taken_ms);
    tasks.push_back(std::move(task));
  }
  return tasks;
}

std::uint64_t milliseconds_of(const FarmTask& task, std::span<const PlantCost> costs) {
  std::uint64_t sum = 0;
  for (const std::uint32_t plant : task.plants) sum += costs[plant].milliseconds;
  return sum;
}

}  // namespace

std::uint64_t memory_limit_bytes(std::uint64_t memory_bytes) {
  return memory_class(memory_bytes + memory_bytes / 2);
}

std::uint32_t time_limit_minutes(std::uint64_t milliseconds) {
  constexpr std::uint64_t kMostMinutes = 60u * 24 * 365;
  return static_cast<std::uint32_t>(std::min(kMostMinutes, 10 + 4 * milliseconds / 60'000));
}

std::vector<FarmArray> plan_arrays(std::span<const PlantCost> costs, const PlanOptions& options) {
  // By limit, the largest first: large plants are the slow ones.
  std::vector<std::uint64_t> limits;
  limits.reserve(costs.size());
  for (const PlantCost& cost : costs) limits.push_back(memory_limit_bytes(cost.memory_bytes));
  if (options.arrays == FarmArrays::one && !limits.empty()) std::ranges::fill(limits, std::ranges::max(limits));
  std::vector<std::uint32_t> order = slowest_first(costs);
  std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) { return limits[a] > limits[b]; });

  TaskSizes sizes(costs, options);
  std::vector<FarmArray> arrays;
  for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
    while (end < order.size() && limits[order[end]] == limits[order[first]]) ++end;
    const std::size_t most = options.arrays == FarmArrays::one ? order.size() : options.most_tasks_of_array;
    for (FarmTask& task : tasks_of(std::span(order).subspan(first, end - first), costs, sizes)) {
      if (arrays.empty() || arrays.back().memory_bytes != limits[order[first]] || arrays.back().tasks.size() == most)
        arrays.push_back({limits[order[first]], 0, {}});
      arrays.back().minutes = std::max(arrays.back().minutes, time_limit_minutes(milliseconds_of(task, costs)));
      arrays.back().tasks.push_back(std::move(task));
    }
  }
  return arrays;
}

std::vector<std::vector<std::uint32_t>> plan_shards(std::span<const PlantCost> costs, std::uint32_t count) {
  std::vector<std::vector<std::uint32_t>> shards(count);
  std::vector<std::uint64_t> taken_ms(count, 0);
  for (const std::uint32_t plant : slowest_first(costs)) {
    const auto least = static_cast<std::size_t>(std::ranges::min_element(taken_ms) - taken_ms.begin());
    taken_ms[least] += costs[plant].milliseconds;
    shards[least].push_back(plant);
  }
  for (std::vector<std::uint32_t>& shard : shards) std::ranges::sort(shard);
  return shards;
}

}  // namespace coppice::bake
