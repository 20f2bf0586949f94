#pragma once

// Computes how coarse the views must be for their demand to fit the budget. If everything fits, the threshold is each view's own. Otherwise
// the threshold rises for all plants alike until it does. So the same error shows everywhere, every request can be granted, no plant waits
// for memory that another holds, and under a still view nothing is loaded that would be evicted again.
//
// The thresholds form a ladder of rungs, from everything at rung 0 to nothing but pinned chunks. What is in demand on a rung holds what is
// in demand on the rungs above it, and the budget only decides how far down demand goes. So more memory never takes anything away. Rungs
// are small: from one to the next only one plant's threshold changes, by 1 %. It goes up in one frame as far as necessary; down by a few
// steps a frame, and only while a little memory stays free.
//
// Textures, wood LoDs and sets of leaf meshes are lumps: loaded all or not at all. In front of a large one memory would stay empty until
// the budget holds it. So a lump larger than a small share of the memory in use on its rung waits until all that is smaller is in memory.
// Only textures are worth more: they wait if they are larger than half. If one of them does not fit, pages go on down the ladder without
// it, and come back up once it does.

#include <array>
#include <cstdint>

#include "bounded_list.h"
#include "budget.h"

namespace coppice {

/// Places in the ladder. Pages are never above lumps.
struct Rungs {
  std::uint32_t pages = 0, lumps = 0;
};

/// A texture, a wood LoD or the leaf meshes of a plant. Less is smaller, or of a lower plant.
struct Lump {
  std::uint64_t bytes = 0;  ///< as LumpLimits count them
  std::uint32_t plant = 0;

  auto operator<=>(const Lump&) const = default;
};
inline constexpr Lump kEveryLump{UINT64_MAX, UINT32_MAX};

struct Threshold {
  Rungs rungs;
  LumpLimits limits;              ///< on the rung of the lumps
  Lump last = kEveryLump;         ///< on rung 0: the largest that is in demand although it is above the limits
  std::uint32_t plant_count = 1;  ///< rungs in a step
  bool falls = false;             ///< demand has just grown, and may grow further
  BoundedList<Lump> large_lumps;  ///< scratch of a frame: at most all lumps of each plant
};

/// The views at a rung: the plants of low index are a step further down.
struct RungViews {
  std::array<GroupViews, 2> at_step;        ///< at `step` and the one after it
  std::uint32_t step = 0, first_later = 0;  ///< plants from first_later on are at the later step

  [[nodiscard]] const GroupViews& of(std::uint32_t plant) const { return at_step[plant < first_later ? 0 : 1]; }
  [[nodiscard]] std::uint32_t step_of(std::uint32_t plant) const { return plant < first_later ? step : step + 1; }
};

/// The demand of all plants.
struct Ladder {
  RungViews pages, lumps;
  LumpLimits limits;
  Lump last;

  [[nodiscard]] DemandViews of(std::uint32_t plant) const;
};

/// The rungs in use. views: with their own thresholds, here and below
[[nodiscard]] Ladder current_ladder(const Threshold& threshold, const GroupViews& views);
/// The views at the highest threshold in use of any plant.
[[nodiscard]] GroupViews threshold_views(const Threshold& threshold, const GroupViews& views);
/// Chooses the rungs, and sets what is in demand of each plant.
void update_demanded(Threshold& threshold, const Budget& budget, const PlantSet& plants, const CurrentFrame& frame);

}  // namespace coppice
