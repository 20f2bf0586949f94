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

#include <algorithm>
#include <cmath>
#include <functional>

#include "streamer_state.h"

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

std::uint64_t comfortable_bytes(std::uint64_t room) {
  return room - room / kFreeShare;
}

}  // namespace

bool Streamer::State::has_view() const {
  return std::ranges::any_of(views, [](const auto& view) { return view.has_value(); });
}

GroupViews Streamer::State::views_at(std::uint32_t step) const {
  GroupViews raised = views;
  for (std::optional<LodView>& view : raised) {
    if (!view || step == 0) continue;
    const float first_px = view->full ? kFirstStepOfFullPx : view->error_px;
    view->error_px = first_px * std::exp2(static_cast<float>(step) / kStepsPerDoubling);
    view->full = false;
  }
  return raised;
}

namespace {

bool is_seen(const PlantStream& plant, DemandSize size) {
  return std::ranges::any_of(plant.demands, [&](const GroupDemand& demand) { return max_size_px(demand, size) > 0.0f; });
}

}  // namespace

std::uint64_t Streamer::State::planned_bytes_at(std::uint32_t step) const {
  PlannedBytes sum;
  const GroupViews raised = views_at(step);
  for (const auto& plant : used_plants()) {
    if (!plant || plant->closing || !is_seen(*plant, DemandSize::recent)) continue;
    const PlannedBytes planned = planned_bytes(*plant, demanded_at(*plant, DemandSize::recent, raised));
    sum.settled += planned.settled;
    sum.passing = std::max(sum.passing, planned.passing);
  }
  return sum.settled + sum.passing;
}

std::uint64_t Streamer::State::room_bytes() const {
  const std::uint64_t room = limit_bytes();
  return room - std::min(room, floor_bytes());
}

void Streamer::State::gather_indivisible() {
  indivisible.clear();
  for (const auto& plant : used_plants()) {
    if (!plant || plant->closing || !is_seen(*plant, DemandSize::now)) continue;
    const DemandedDetail& demanded = plant->demanded.unlimited;
    std::uint64_t set_bytes = 0;
    Chunk* of_set = nullptr;
    for (Chunk& chunk : plant->chunks.span().subspan(plant->file.plant.page_count)) {
      if (chunk.id.kind == ChunkKind::wood || chunk.residency == Residency::failed) continue;
      const std::uint64_t bytes = chunk_bytes(*plant, chunk).gpu;
      if (!in_leaf_mesh_set(*plant, chunk)) {
        if (demanded.textures) indivisible.push_back({&chunk, &chunk.affordable, bytes});
        continue;
      }
      set_bytes += bytes;
      of_set = &chunk;
    }
    if (demanded.leaf_meshes) indivisible.push_back({of_set, &plant->leaf_meshes_affordable, set_bytes});
  }
}

void Streamer::State::choose_indivisible(std::uint64_t room) {
  gather_indivisible();
  const std::span<Indivisible> items = indivisible.span();
  for (const Indivisible& item : items) *item.affordable = true;
  all_affordable = planned_bytes_at(0) <= (all_affordable ? room : comfortable_bytes(room));
  if (all_affordable) return;
  for (Indivisible& item : items) {
    item.value = value_of(*plants[item.chunk->id.plant], *item.chunk);
    if (item.chunk->residency != Residency::absent) item.value *= kExchangeMargin;
  }
  std::uint64_t left = room / 4 * 3;
  std::ranges::stable_sort(items, std::greater{}, &Indivisible::value);
  for (const Indivisible& item : items) {
    *item.affordable = item.bytes <= left;
    if (*item.affordable) left -= item.bytes;
  }
}

void Streamer::State::choose_threshold(std::uint64_t room) {
  const std::uint64_t comfortable = comfortable_bytes(room);
  if (planned_bytes_at(threshold_step) <= room) {
    const auto fits_below = [&](std::uint32_t steps) {
      return threshold_step >= steps && planned_bytes_at(threshold_step - steps) <= comfortable;
    };
    if (fits_below(1)) threshold_step -= fits_below(kMaxStepsDown) ? kMaxStepsDown : 1;
    return;
  }
  std::uint32_t too_low = threshold_step, enough = threshold_step;
  for (std::uint32_t stride = 1; enough < kMaxSteps; stride *= 2) {
    too_low = enough;
    enough = std::min(enough + stride, kMaxSteps);
    if (planned_bytes_at(enough) <= comfortable) break;
  }
  while (enough - too_low > 1) {
    const std::uint32_t middle = (too_low + enough) / 2;
    (planned_bytes_at(middle) <= comfortable ? enough : too_low) = middle;
  }
  threshold_step = enough;
}

void Streamer::State::update_demanded() {
  for (const auto& plant : used_plants()) {
    if (!plant) continue;
    plant->leaf_meshes_affordable = true;
    plant->demanded.unlimited = demanded_at(*plant, DemandSize::now, views);
  }
  const std::uint32_t step_before = threshold_step;
  if (has_view()) {
    const std::uint64_t room = room_bytes();
    choose_indivisible(room);
    choose_threshold(room);
  }
  threshold_falls = threshold_step < step_before;
  const GroupViews raised = views_at(threshold_step);
  for (const auto& plant : used_plants()) {
    if (!plant) continue;
    plant->demanded.now = demanded_at(*plant, DemandSize::now, raised);
    plant->demanded.recent = demanded_at(*plant, DemandSize::recent, raised);
  }
}

}  // namespace coppice
