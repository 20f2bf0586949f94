#include "threshold.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace coppice {

namespace {

constexpr float kStepsPerDoubling = 64.0f;
constexpr std::uint32_t kMaxSteps = 64 * 24;
constexpr std::uint32_t kMaxStepsDown = 8;  ///< maximum in a frame
/// Step 1 of a view that shows every leaf, whose own threshold is 0.
constexpr float kFirstStepOfFullPx = 1.0f / 16.0f;
/// Share of the memory that must stay free when demand grows, because it changes a little from frame to frame.
constexpr std::uint64_t kFreeShare = 128;
/// Maximum share of the memory in use that a lump takes: a texture, and others.
constexpr std::uint64_t kTextureShare = 2, kLumpShare = 32;
/// Pages go on without lumps if this share of the memory would stay free. It is more than kLumpShare and kFreeShare together, so they do
/// not for the sake of a small lump.
constexpr std::uint64_t kUnusedShare = 24, kLittleUnusedShare = 28;

GroupViews views_at(std::uint32_t step, const GroupViews& views) {
  GroupViews raised = views;
  for (std::optional<LodView>& view : raised) {
    if (!view || step == 0) continue;
    const float first_px = view->full ? kFirstStepOfFullPx : view->error_px;
    view->error_px = first_px * std::exp2(static_cast<float>(step) / kStepsPerDoubling);
    view->full = false;
  }
  return raised;
}

RungViews views_on(std::uint32_t rung, std::uint32_t plant_count, const GroupViews& views) {
  const std::uint32_t step = rung / plant_count, later_count = rung % plant_count;
  return {{views_at(step, views), views_at(step + 1, views)}, step, plant_count - later_count};
}

bool is_seen(const PlantStream& plant, DemandSize size) {
  return std::ranges::any_of(plant.demands, [&](const GroupDemand& demand) { return max_size_px(demand, size) > 0.0f; });
}

/// A frame's demand on all rungs.
struct Demand {
  const PlantSet& plants;
  const GroupViews& views;
  std::uint64_t floor_bytes = 0, limit_bytes = 0;
  std::uint32_t plant_count = 1;  ///< rungs in a step

  [[nodiscard]] std::uint64_t room_bytes() const { return limit_bytes - std::min(limit_bytes, floor_bytes); }
  [[nodiscard]] std::uint64_t comfortable_bytes() const { return room_bytes() - room_bytes() / kFreeShare; }
};

PlannedBytes planned_on(const Demand& demand, const Ladder& ladder) {
  PlannedBytes sum;
  for_each_open(demand.plants, [&](const PlantStream& plant) {
    if (!is_seen(plant, DemandSize::recent)) return;
    const PlannedBytes planned = planned_bytes(plant, demanded_at(plant, DemandSize::recent, ladder.of(plant.index)));
    sum.settled += planned.settled;
    sum.passing = std::max(sum.passing, planned.passing);
  });
  return sum;
}

/// Memory that the demand needs.
std::uint64_t needed_bytes(const Demand& demand, Rungs rungs, LumpLimits limits, Lump last = {}) {
  const auto views = [&](std::uint32_t rung) { return views_on(rung, demand.plant_count, demand.views); };
  const PlannedBytes planned = planned_on(demand, {views(rungs.pages), views(rungs.lumps), limits, last});
  return planned.settled + planned.passing;
}

/// By the memory in use without lumps, which grows from rung to rung whatever the budget.
LumpLimits limits_on(const Demand& demand, std::uint32_t rung) {
  const RungViews views = views_on(rung, demand.plant_count, demand.views);
  const std::uint64_t bytes = demand.floor_bytes + planned_on(demand, {views, views, {0, 0}, {}}).settled;
  return {bytes / kTextureShare, bytes / kLumpShare};
}

/// Returns the rung to use after `now`. needed(rung): bytes, which do not grow from rung to rung; no more than fit on the last one
template <class Needed>
std::uint32_t next_rung(std::uint32_t now, const Demand& demand, const Needed& needed) {
  const std::uint64_t comfortable = demand.comfortable_bytes();
  const auto first_that_fits = [&](std::uint32_t too_low, std::uint32_t enough) {
    while (enough - too_low > 1) {
      const std::uint32_t middle = too_low + (enough - too_low) / 2;
      (needed(middle) <= comfortable ? enough : too_low) = middle;
    }
    return enough;
  };
  if (needed(now) <= demand.room_bytes()) {
    if (now == 0 || needed(now - 1) > comfortable) return now;
    const std::uint32_t lowest = now - std::min(now, kMaxStepsDown * demand.plant_count);
    return needed(lowest) <= comfortable ? lowest : first_that_fits(lowest, now - 1);
  }
  const std::uint32_t last = kMaxSteps * demand.plant_count;
  std::uint32_t too_low = now, enough = now;
  for (std::uint32_t stride = 1; enough < last; stride *= 2) {
    too_low = enough;
    enough = std::min(enough + stride, last);
    if (needed(enough) <= comfortable) break;
  }
  return first_that_fits(too_low, enough);
}

/// Takes the lumps that are above the limits, in ascending order.
void gather_large(const Demand& demand, LumpLimits limits, BoundedList<Lump>& large) {
  large.clear();
  for_each_open(demand.plants, [&](const PlantStream& plant) {
    if (!is_seen(plant, DemandSize::recent)) return;
    const auto take = [&](std::uint64_t bytes) {
      if (bytes > limits.other_bytes) large.push_back({bytes, plant.index});
    };
    if (plant.valued.leaf_mesh_bytes > 0) take(plant.leaf_mesh_load_bytes);
    for (const Chunk& chunk : plant.other_chunks())
      if (!in_leaf_mesh_set(plant, chunk)) take(lump_bytes(plant, chunk));
  });
  std::ranges::sort(large.span());
}

/// Returns the last lump that fits beside all that is smaller. now: the one in use
Lump last_lump(const Demand& demand, Lump now, LumpLimits limits, BoundedList<Lump>& large) {
  const auto fits = [&](Lump last) {
    return needed_bytes(demand, {}, limits, last) <= (last <= now ? demand.room_bytes() : demand.comfortable_bytes());
  };
  if (fits(kEveryLump)) return kEveryLump;
  gather_large(demand, limits, large);
  const auto end = std::ranges::partition_point(large.span(), fits);
  return end == large.span().begin() ? Lump{} : *(end - 1);
}

void choose_rungs(Threshold& threshold, const Demand& demand) {
  const Rungs before = threshold.rungs;
  const auto together = [&](std::uint32_t rung) { return needed_bytes(demand, {rung, rung}, limits_on(demand, rung)); };
  const std::uint32_t lumps = next_rung(before.lumps, demand, together);
  const LumpLimits limits = limits_on(demand, lumps);
  const std::uint64_t unused = demand.room_bytes() - std::min(demand.room_bytes(), needed_bytes(demand, {lumps, lumps}, limits));
  std::uint32_t pages = std::min(before.pages, lumps);
  const bool goes_on = pages < lumps ? unused > demand.limit_bytes / kLittleUnusedShare
                                     : lumps == before.lumps && unused > demand.limit_bytes / kUnusedShare;
  pages = !goes_on ? lumps : next_rung(pages, demand, [&](std::uint32_t rung) { return needed_bytes(demand, {rung, lumps}, limits); });
  threshold.rungs = {std::min(pages, lumps), lumps};
  threshold.limits = limits;
  const Lump last = std::exchange(threshold.last, lumps == 0 ? last_lump(demand, threshold.last, limits, threshold.large_lumps) : Lump{});
  threshold.falls = lumps < before.lumps || pages < before.pages || threshold.last > last;
}

}  // namespace

DemandViews Ladder::of(std::uint32_t plant) const {
  const std::uint64_t least = last.bytes - (last.bytes > 0 && plant > last.plant ? 1 : 0);
  const LumpLimits of_plant{std::max(limits.texture_bytes, least), std::max(limits.other_bytes, least)};
  return {pages.of(plant), lumps.of(plant), of_plant, lumps.step_of(plant) == 0};
}

Ladder current_ladder(const Threshold& threshold, const GroupViews& views) {
  return {views_on(threshold.rungs.pages, threshold.plant_count, views), views_on(threshold.rungs.lumps, threshold.plant_count, views),
          threshold.limits, threshold.last};
}

GroupViews threshold_views(const Threshold& threshold, const GroupViews& views) {
  return views_at((threshold.rungs.lumps + threshold.plant_count - 1) / threshold.plant_count, views);
}

void update_demanded(Threshold& threshold, const Budget& budget, const PlantSet& plants, const CurrentFrame& frame) {
  for (const auto& plant : plants.used())
    if (plant) plant->demanded.unlimited = demanded_at(*plant, DemandSize::now, {frame.views, frame.views, {}});
  if (const std::uint32_t count = std::max(plants.end, 1u); count != threshold.plant_count) {
    for (std::uint32_t* rung : {&threshold.rungs.pages, &threshold.rungs.lumps})
      *rung = (*rung + threshold.plant_count - 1) / threshold.plant_count * count;
    threshold.plant_count = count;
  }
  if (std::ranges::any_of(frame.views, [](const auto& view) { return view.has_value(); }))
    choose_rungs(threshold, {plants, frame.views, floor_bytes(budget, plants), limit_bytes(budget, plants), threshold.plant_count});
  else
    threshold.falls = false;
  const Ladder ladder = current_ladder(threshold, frame.views);
  for (const auto& plant : plants.used()) {
    if (!plant) continue;
    plant->demanded.now = demanded_at(*plant, DemandSize::now, ladder.of(plant->index));
    plant->demanded.recent = demanded_at(*plant, DemandSize::recent, ladder.of(plant->index));
  }
}

}  // namespace coppice
