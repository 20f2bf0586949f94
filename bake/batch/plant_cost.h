#pragma once

// What a bake will take, told from a look at the file's JSON, before anybody has baked it: by it plants are ordered, dealt out to machines,
// and given memory.

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "bake.h"

namespace coppice::bake {

/// Integers, so that every machine deals out alike.
struct PlantCost {
  std::uint64_t milliseconds = 0;  ///< on one processor
  std::uint64_t memory_bytes = 0;  ///< peak
  friend bool operator==(const PlantCost&, const PlantCost&) = default;
};

/// Triangles of a document's scene in all places (check_cost), the bytes of the input with those that it refers to, and what these files
/// are.
struct InputCounts {
  std::uint64_t triangles = 0, bytes = 0;
  std::vector<std::filesystem::path> files = {};  ///< whether there or not
};

/// Reads the JSON of the input and sizes of files, no geometry: about a millisecond. What outline_gltf refuses counts with its own bytes:
/// the bake will say what is wrong with it.
InputCounts count_input(const std::filesystem::path& input, const ImportOptions& options);

/// An estimate by a fit to measured bakes, which tests/bench/results/cluster.md has. Cached plants cost as much as others.
PlantCost plant_cost(const InputCounts& counts, const BakeOptions& options);

/// Indices by falling time; of equal ones the first first.
std::vector<std::uint32_t> slowest_first(std::span<const PlantCost> costs);

/// The share of all plants' time that is done.
/// done  [costs.size()] of each plant's, 0..1
double done_fraction(std::span<const PlantCost> costs, std::span<const double> done);

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
