#include "measured_visibility.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "bounds.h"

namespace coppice::bake {

MeasuredVisibility::MeasuredVisibility(const Foliage& foliage, const std::vector<Viewpoint>& views, std::uint32_t resolution_px,
                                       MeasureAreas measure)
    : resolution_px_(resolution_px),
      measure_(std::move(measure)),
      leaves_(2 * foliage.leaf_count() - 1),
      live_(foliage.leaf_count()),
      areas_px_((leaves_.size() + 1) * views.size(), 0) {
  const Sphere sphere = bounding_sphere(foliage);
  for (const Viewpoint& view : views) projections_.push_back(make_projection(view, sphere, resolution_px));
  for (std::uint32_t id = 0; id < foliage.leaf_count(); ++id) leaves_[id] = {.quad = foliage.quads[id], .card = foliage.cards[id]};
  std::iota(live_.begin(), live_.end(), 0u);
  const std::vector<std::uint32_t> px = measured(live_, {});
  const auto background_px = px.end() - static_cast<std::ptrdiff_t>(views.size());
  std::copy(px.begin(), background_px, areas_px_.begin());
  std::copy_backward(background_px, px.end(), areas_px_.end());
}

void MeasuredVisibility::areas_after(std::uint32_t outcome, std::span<const std::int32_t> delta_px, std::vector<std::uint32_t>& row) const {
  const std::span<const std::uint32_t> now = areas(outcome);
  row.assign(now.begin(), now.end());
  for (std::size_t v = 0; v < delta_px.size(); ++v) row[v] += static_cast<std::uint32_t>(delta_px[v]);
}

std::vector<std::uint32_t> MeasuredVisibility::measured(const std::vector<std::uint32_t>& ids, std::span<const PixelBox> changed) {
  std::vector<Quad> quads;
  std::vector<std::uint32_t> cards, areas_px;
  const auto append_areas = [&](std::uint32_t outcome) { areas_px.insert(areas_px.end(), areas(outcome).begin(), areas(outcome).end()); };
  for (const std::uint32_t id : ids) {
    quads.push_back(leaves_[id].quad);
    cards.push_back(leaves_[id].card);
    append_areas(id);
  }
  append_areas(background());
  if (failure_) failure_ = measure_({quads, cards, changed}, areas_px);
  return areas_px;
}

void MeasuredVisibility::changes_of(const LeafMerge& merge, const OwnedPixels&, Scratch&, AreaChanges& changes) {
  leaves_[merge.result] = merge.leaf;
  std::vector<PixelBox> changed(view_count());
  for (std::size_t v = 0; v < changed.size(); ++v)
    for (const std::uint32_t id : {merge.first, merge.second, merge.result})
      changed[v] = united(changed[v], pixel_box(project(projections_[v], leaves_[id].quad), projections_[v].resolution_px));
  std::vector<std::uint32_t> outcomes = live_;
  std::erase(outcomes, merge.first);
  std::erase(outcomes, merge.second);
  outcomes.push_back(merge.result);
  const std::vector<std::uint32_t> after_px = measured(outcomes, changed);
  outcomes.push_back(background());

  changes.outcomes.clear();
  changes.delta_px.clear();
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const std::span<const std::uint32_t> before = areas(outcomes[i]), after = std::span(after_px).subspan(i * view_count(), view_count());
    if (std::ranges::equal(after, before)) continue;
    changes.outcomes.push_back(outcomes[i]);
    for (std::size_t v = 0; v < after.size(); ++v) changes.delta_px.push_back(static_cast<std::int32_t>(after[v] - before[v]));
  }
}

void MeasuredVisibility::apply(const LeafMerge& merge, const AreaChanges& changes) {
  leaves_[merge.result] = merge.leaf;
  std::erase(live_, merge.first);
  std::erase(live_, merge.second);
  live_.push_back(merge.result);
  for (std::size_t i = 0; i < changes.outcomes.size(); ++i)
    for (std::size_t v = 0; v < view_count(); ++v)
      areas_px_[std::size_t{changes.outcomes[i]} * view_count() + v] += static_cast<std::uint32_t>(changes.row(i, view_count())[v]);
}

}  // namespace coppice::bake
