#include "batch_plan.h"

#include <algorithm>

namespace coppice::bake {

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
