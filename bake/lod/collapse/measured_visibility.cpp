#include "measured_visibility.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "bounds.h"

namespace coppice::bake {

MeasuredVisibility::MeasuredVisibility(const Foliage& foliage, const std::vector<Viewpoint>& views, std::uint32_t resolution_px,
                                       MeasureAreas measure)
    : resolution_px_(resolution_px), measure_(std::move(measure)), leaves_(2 * foliage.leaf_count() - 1), place_(leaves_.size(), kNone) {
  const Sphere sphere = bounding_sphere(foliage);
  for (const Viewpoint& view : views) projections_.push_back(make_projection(view, sphere, resolution_px));
  for (std::uint32_t id = 0; id < foliage.leaf_count(); ++id) leaves_[id] = {foliage.quads[id], foliage.cards[id]};
  live_.ids.resize(foliage.leaf_count());
  std::iota(live_.ids.begin(), live_.ids.end(), 0u);
  std::iota(place_.begin(), place_.begin() + static_cast<std::ptrdiff_t>(foliage.leaf_count()), 0u);
  live_.quads = foliage.quads;
  live_.cards = foliage.cards;
  live_.areas_px.assign((live_.ids.size() + 1) * view_count(), 0);
  this->measure(live_, {});
}

void MeasuredVisibility::areas_after(std::uint32_t outcome, std::span<const std::int32_t> delta_px, std::vector<std::uint32_t>& row) const {
  const std::size_t place = outcome == background() ? live_.ids.size() : place_[outcome];
  row.assign(view_count(), 0);
  if (place != kNone) std::copy_n(live_.areas_px.begin() + static_cast<std::ptrdiff_t>(place * view_count()), view_count(), row.begin());
  for (std::size_t v = 0; v < delta_px.size(); ++v) row[v] += static_cast<std::uint32_t>(delta_px[v]);
}

/// Puts the merged leaf in the first one's place, without area yet, and the last leaf in the second one's.
void MeasuredVisibility::merge_into(const LeafMerge& merge, Leaves& leaves) const {
  const std::size_t first = place_[merge.first], second = place_[merge.second], last = leaves.ids.size() - 1;
  const auto row = [&](std::size_t place) { return leaves.areas_px.begin() + static_cast<std::ptrdiff_t>(place * view_count()); };
  leaves.ids[first] = merge.result;
  leaves.quads[first] = merge.leaf.quad;
  leaves.cards[first] = merge.leaf.card;
  std::fill_n(row(first), view_count(), 0u);
  leaves.ids[second] = leaves.ids[last];
  leaves.quads[second] = leaves.quads[last];
  leaves.cards[second] = leaves.cards[last];
  if (second != last) std::copy_n(row(last), view_count(), row(second));
  std::copy_n(row(last + 1), view_count(), row(last));
  leaves.ids.pop_back();
  leaves.quads.pop_back();
  leaves.cards.pop_back();
  leaves.areas_px.resize(leaves.areas_px.size() - view_count());
}

void MeasuredVisibility::measure(Leaves& leaves, std::span<const PixelBox> changed) {
  if (failure_) failure_ = measure_({leaves.quads, leaves.cards, changed}, leaves.areas_px);
}

void MeasuredVisibility::changes_of(const LeafMerge& merge, const OwnedPixels&, Scratch&, AreaChanges& changes) {
  std::vector<PixelBox> changed(view_count());
  for (std::size_t v = 0; v < changed.size(); ++v)
    for (const LiveLeaf* leaf : std::array<const LiveLeaf*, 3>{&leaves_[merge.first], &leaves_[merge.second], &merge.leaf})
      changed[v] = united(changed[v], pixel_box(project(projections_[v], leaf->quad), projections_[v].resolution_px));
  trial_ = live_;
  merge_into(merge, trial_);
  measure(trial_, changed);

  changes.outcomes.clear();
  changes.delta_px.clear();
  std::vector<std::uint32_t> before;
  for (std::size_t place = 0; place <= trial_.ids.size(); ++place) {
    const std::uint32_t outcome = place == trial_.ids.size() ? background() : trial_.ids[place];
    const std::span<const std::uint32_t> after = std::span(trial_.areas_px).subspan(place * view_count(), view_count());
    areas_after(outcome, {}, before);
    if (std::ranges::equal(after, before)) continue;
    changes.outcomes.push_back(outcome);
    for (std::size_t v = 0; v < after.size(); ++v) changes.delta_px.push_back(static_cast<std::int32_t>(after[v] - before[v]));
  }
}

void MeasuredVisibility::apply(const LeafMerge& merge, const AreaChanges& changes) {
  leaves_[merge.result] = merge.leaf;
  merge_into(merge, live_);
  place_[merge.first] = kNone;
  place_[merge.second] = kNone;
  for (std::uint32_t place = 0; place < live_.ids.size(); ++place) place_[live_.ids[place]] = place;
  for (std::size_t i = 0; i < changes.outcomes.size(); ++i) {
    const std::size_t place = changes.outcomes[i] == background() ? live_.ids.size() : place_[changes.outcomes[i]];
    for (std::size_t v = 0; v < view_count(); ++v)
      live_.areas_px[place * view_count() + v] += static_cast<std::uint32_t>(changes.row(i, view_count())[v]);
  }
}

}  // namespace coppice::bake
