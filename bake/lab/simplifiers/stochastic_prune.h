#pragma once

// The stochastic baseline (Cook, Halstead, Planck, Ryu: Stochastic Simplification of Aggregate Detail, SIGGRAPH 2007): prunes leaves in a
// random order; the remaining leaves grow so that the total area stays.

#include <cstdint>
#include <vector>

#include "plant.h"

namespace coppice::bake {

/// 0 .. leaf_count - 1 in random order, the same for the same count and seed.
std::vector<std::uint32_t> stochastic_order(std::uint32_t leaf_count, std::uint64_t seed);

/// Keeps the first kept_count leaves of stochastic_order, in leaf order, each scaled about its centroid by 1 / sqrt(kept_count /
/// leaf_count).
/// kept_count  1 .. leaf_count (asserted)
Foliage prune_stochastically(const Foliage& foliage, std::uint32_t kept_count, std::uint64_t seed);

}  // namespace coppice::bake
