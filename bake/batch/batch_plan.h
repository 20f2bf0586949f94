#pragma once

// Which plants are baked together: in tasks of a cluster, and in shards.

#include <cstdint>
#include <span>
#include <vector>

#include "plant_cost.h"

namespace coppice::bake {

/// Plants that one process bakes, by their indices.
using PlantGroup = std::vector<std::uint32_t>;

struct TaskPlan {
  std::uint32_t slots = 32;  ///< tasks that may run at a time, as far as is known; >= 1
  std::uint64_t max_task_ms = 300'000, min_task_ms = 10'000;
  std::uint32_t max_tasks = 1000;  ///< about; >= 1. Slurm's MaxArraySize is 1001 by default
};

/// Puts every plant of `costs` into one task. The slowest plants come first. Tasks become shorter towards the end, from a share of the
/// remaining work for every slot down to min_task_ms, so that all slots end at about the same time. The same costs give the same tasks.
std::vector<PlantGroup> plan_tasks(std::span<const PlantCost> costs, const TaskPlan& plan);

/// Deals the plants out to `count` >= 1 shards of nearly equal cost: the slowest first, each to the shard that has least. Indices of a
/// shard rise. The same costs give the same shards on every machine. Shards may be empty.
std::vector<PlantGroup> plan_shards(std::span<const PlantCost> costs, std::uint32_t count);

}  // namespace coppice::bake
