#pragma once

// What a bake will take, told from a look at the file's JSON: where plants are dealt out to machines before anybody has baked them.

#include <cstdint>

#include "bake_batch.h"

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

/// Reads the JSON of the input and sizes of files, no geometry: about a millisecond. What cannot be read, or makes no sense, counts 0: the
/// bake will say what is wrong with it.
InputCounts count_input(const BatchPlant& plant);

/// An estimate by a fit to measured bakes, which DECISIONS.md tells of. Cached plants cost as much as others.
PlantCost plant_cost(const BatchPlant& plant);

/// The same from the counts, which the tests give.
PlantCost plant_cost(const InputCounts& counts, const BakeOptions& options);

}  // namespace coppice::bake
