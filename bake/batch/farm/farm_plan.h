#pragma once

// Which plants are baked together, on a cluster and in shards.

#include <cstdint>
#include <span>
#include <vector>

#include "plant_cost.h"

namespace coppice::bake {

/// Plants that one process of one machine bakes, by their indices.
struct FarmTask {
  std::vector<std::uint32_t> plants;
};

/// Tasks that get the same limits.
struct FarmArray {
  std::uint64_t memory_bytes = 0;  ///< of a task on one processor
  std::uint32_t minutes = 0;       ///< wall time of a task
  std::vector<FarmTask> tasks;     ///< the slowest first
};

enum class FarmArrays : std::uint8_t {
  by_memory,
  one  ///< whatever its size
};

struct PlanOptions {
  std::uint32_t slots = 32;  ///< tasks that may run at a time, as far as is known; >= 1
  std::uint64_t longest_task_ms = 300'000, shortest_task_ms = 10'000;
  std::uint32_t most_tasks = 4000;           ///< of all arrays, about; >= 1. Slurm's MaxJobCount is 10,000 by default
  std::uint32_t most_tasks_of_array = 1000;  ///< >= 1. Slurm's MaxArraySize is 1001 by default
  FarmArrays arrays = FarmArrays::by_memory;
};

/// Every plant of `costs` in one task. Plants whose memory is within a factor of two share an array, as one array has one limit. In each
/// the slowest plants come first, and tasks become shorter to the end, from a share of what is left for every slot down to
/// shortest_task_ms, so that all slots end at about the same time. Limits leave room for an estimate that is wrong: 1.5 times the memory,
/// four times the time and ten minutes. The same costs give the same plan.
std::vector<FarmArray> plan_arrays(std::span<const PlantCost> costs, const PlanOptions& options);

/// `count` >= 1 parts of nearly equal cost, together every plant once: the slowest first, each into the part that has least. Indices of a
/// part rise. The same costs give the same parts on every machine. Parts may be empty.
std::vector<std::vector<std::uint32_t>> plan_shards(std::span<const PlantCost> costs, std::uint32_t count);

/// The limit of a task on one processor for plants that need so much.
std::uint64_t memory_limit_bytes(std::uint64_t memory_bytes);
/// The limit of a task of plants that take so long together.
std::uint32_t time_limit_minutes(std::uint64_t milliseconds);

}  // namespace coppice::bake
