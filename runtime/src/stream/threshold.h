#pragma once

// Computes how coarse the views must be for their demand to fit the budget. If everything fits, the threshold is each view's own. Otherwise
// the threshold rises for all plants alike until it does. So the same error shows everywhere, every request can be granted, no plant waits
// for memory that another holds, and under a still view nothing is loaded that would be evicted again.
//
// The threshold moves in steps of 2 %: up in one frame as far as necessary; down by a few steps a frame, and only while some memory stays
// free.
//
// Textures and sets of leaf meshes are loaded all or not at all, and one of them may be larger than everything else: no threshold that
// still shows anything could make them fit. If not everything fits they share three quarters of the memory, highest value per byte first;
// the threshold governs the rest.

#include <cstdint>

#include "bounded_list.h"
#include "budget.h"

namespace coppice {

/// Chunks that are loaded all or not at all.
struct Indivisible {
  Chunk* chunk = nullptr;  ///< a texture, or one chunk of the plant's leaf meshes for all of them
  bool* affordable = nullptr;
  std::uint64_t bytes = 0;
  float value = 0.0f;
};

struct Threshold {
  std::uint32_t step = 0;  ///< number of steps by which the thresholds in use are above the views' own
  bool falls = false;      ///< step has just fallen, and may fall further
  bool all_affordable = true;
  BoundedList<Indivisible> indivisible;  ///< scratch of a frame: at most the textures of each plant, and its leaf meshes
};

/// The views at the thresholds in use.
[[nodiscard]] GroupViews raised_views(const Threshold& threshold, const CurrentFrame& frame);
/// Chooses the thresholds, and sets what is in demand of each plant.
void update_demanded(Threshold& threshold, const Budget& budget, const PlantSet& plants, const CurrentFrame& frame);

}  // namespace coppice
