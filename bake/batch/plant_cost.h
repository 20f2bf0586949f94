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
  std::uint64_t milliseconds = 0;  ///< of one processor
  std::uint64_t memory_bytes = 0;  ///< peak
  friend bool operator==(const PlantCost&, const PlantCost&) = default;
};

/// Triangles as a document's scene graph has them, instances too, and the bytes of the input with those that it refers to.
struct InputCounts {
  std::uint64_t triangles = 0, bytes = 0;
};

/// Reads the JSON of the input and sizes of files, no geometry: about a millisecond. What cannot be read, makes no sense, or is over 32 MiB
/// of JSON counts 0: the bake will say what is wrong with it.
InputCounts count_input(const std::filesystem::path& input, const ImportOptions& options);

/// An estimate by a fit to measured bakes, which DECISIONS.md tells of. Cached plants cost as much as others.
PlantCost plant_cost(const InputCounts& counts, const BakeOptions& options);

/// Indices by falling time; of equal ones the first first.
std::vector<std::uint32_t> slowest_first(std::span<const PlantCost> costs);

}  // namespace coppice::bake
