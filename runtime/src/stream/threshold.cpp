#include "threshold.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace coppice {

namespace {

constexpr float kStepsPerDoubling = 32.0f;
constexpr std::uint32_t kMaxSteps = 32 * 24;
constexpr std::uint32_t kMaxStepsDown = 4;  ///< maximum in a frame
/// Step 1 of a view that shows every leaf, whose own threshold is 0.
constexpr float kFirstStepOfFullPx = 1.0f / 16.0f;
/// Share of the memory that must stay free when the threshold falls, because demand changes a little from frame to frame.
constexpr std::uint64_t kFreeShare = 16;
/// A resident set counts this much more than its replacement: small changes of the view must not swap them back and forth.
constexpr float kExchangeMargin = 1.5f;

std::uint64_t comfortable_bytes(std::uint64_t room_bytes) {
  return room_bytes - room_bytes / kFreeShare;
}

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

bool is_seen(const PlantStream& plant, DemandSize size) {
  return std::ranges::any_of(plant.demands, [&](const GroupDemand& demand) { return max_size_px(demand, size) > 0.0f; });
}

/// Memory that the demand at a step needs.
std::uint64_t planned_bytes_at(std::uint32_t step, const PlantSet& plants, const GroupViews& views) {
  PlannedBytes sum;
  const GroupViews raised = views_at(step, views);
  for_each_open(plants, [&](const PlantStream& plant) {
    if (!is_seen(plant, DemandSize::recent)) return;
    const PlannedBytes planned = planned_bytes(plant, demanded_at(plant, DemandSize::recent, raised));
    sum.settled += planned.settled;
    sum.passing = std::max(sum.passing, planned.passing);
  });
  return sum.settled + sum.passing;
}

void gather_indivisible(const PlantSet& plants, BoundedList<Indivisible>& items) {
  items.clear();
  for_each_open(plants, [&](PlantStream& plant) {
    if (!is_seen(plant, DemandSize::now)) return;
    const DemandedDetail& demanded = plant.demanded.unlimited;
    Indivisible set{.affordable = &plant.leaf_meshes_affordable};
    for (Chunk& chunk : plant.other_chunks()) {
      if (chunk.id.kind == ChunkKind::wood || chunk.residency == Residency::failed) continue;
      const std::uint64_t bytes = chunk_bytes(plant, chunk).gpu;
      if (!in_leaf_mesh_set(plant, chunk)) {
        if (demanded.textures) items.push_back({&chunk, &chunk.affordable, bytes});
        continue;
      }
      set.bytes += bytes;
      set.chunk = &chunk;
    }
    if (demanded.leaf_meshes) items.push_back(set);
  });
}

/// Decides which textures and leaf meshes may be requested.
void choose_indivisible(Threshold& threshold, std::uint64_t room_bytes, const PlantSet& plants, const CurrentFrame& frame) {
  gather_indivisible(plants, threshold.indivisible);
  const std::span<Indivisible> items = threshold.indivisible.span();
  for (const Indivisible& item : items) *item.affordable = true;
  threshold.all_affordable =
      planned_bytes_at(0, plants, frame.views) <= (threshold.all_affordable ? room_bytes : comfortable_bytes(room_bytes));
  if (threshold.all_affordable) return;
  for (Indivisible& item : items) {
    item.value = chunk_value(plants.at(item.chunk->id.plant), *item.chunk, frame);
    if (item.chunk->residency != Residency::absent) item.value *= kExchangeMargin;
  }
  std::uint64_t left = room_bytes / 4 * 3;
  std::ranges::stable_sort(items, std::greater{}, &Indivisible::value);
  for (const Indivisible& item : items) {
    *item.affordable = item.bytes <= left;
    if (*item.affordable) left -= item.bytes;
  }
}

/// Returns the step to use after `now`.
std::uint32_t next_step(std::uint32_t now, std::uint64_t room_bytes, const PlantSet& plants, const GroupViews& views) {
  const std::uint64_t comfortable = comfortable_bytes(room_bytes);
  const auto planned_at = [&](std::uint32_t step) { return planned_bytes_at(step, plants, views); };
  if (planned_at(now) <= room_bytes) {
    const auto fits_below = [&](std::uint32_t steps) { return now >= steps && planned_at(now - steps) <= comfortable; };
    if (!fits_below(1)) return now;
    return now - (fits_below(kMaxStepsDown) ? kMaxStepsDown : 1);
  }
  std::uint32_t too_low = now, enough = now;
  for (std::uint32_t stride = 1; enough < kMaxSteps; stride *= 2) {
    too_low = enough;
    enough = std::min(enough + stride, kMaxSteps);
    if (planned_at(enough) <= comfortable) break;
  }
  while (enough - too_low > 1) {
    const std::uint32_t middle = (too_low + enough) / 2;
    (planned_at(middle) <= comfortable ? enough : too_low) = middle;
  }
  return enough;
}

}  // namespace

GroupViews raised_views(const Threshold& threshold, const CurrentFrame& frame) {
  return views_at(threshold.step, frame.views);
}

void update_demanded(Threshold& threshold, const Budget& budget, const PlantSet& plants, const CurrentFrame& frame) {
  for (const auto& plant : plants.used()) {
    if (!plant) continue;
    plant->leaf_meshes_affordable = true;
    plant->demanded.unlimited = demanded_at(*plant, DemandSize::now, frame.views);
  }
  const std::uint32_t step_before = threshold.step;
  if (std::ranges::any_of(frame.views, [](const auto& view) { return view.has_value(); })) {
    const std::uint64_t limit = limit_bytes(budget, plants);
    const std::uint64_t room_bytes = limit - std::min(limit, floor_bytes(budget, plants));
    choose_indivisible(threshold, room_bytes, plants, frame);
    threshold.step = next_step(step_before, room_bytes, plants, frame.views);
  }
  threshold.falls = threshold.step < step_before;
  const GroupViews raised = raised_views(threshold, frame);
  for (const auto& plant : plants.used()) {
    if (!plant) continue;
    plant->demanded.now = demanded_at(*plant, DemandSize::now, raised);
    plant->demanded.recent = demanded_at(*plant, DemandSize::recent, raised);
  }
}

}  // namespace coppice
