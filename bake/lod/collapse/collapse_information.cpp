// Algorithm 1. Each step takes the live leaf of smallest visibility, asks the octree for partners, computes for each partner how the merge
// would change every leaf's area in every view, hence I(V,L), and does the cheapest merge. Partners are evaluated in parallel and share
// nothing that they write, and the choice between them is made on integers, so the sequence does not depend on threads.

#include "collapse_information.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <set>
#include <utility>

#include <tbb/enumerable_thread_specific.h>

#include "bounds.h"
#include "collapse_down.h"
#include "live_visibility.h"
#include "mutual_information.h"
#include "octree.h"
#include "parallel_for.h"
#include "quad_merge.h"
#include "stopwatch.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

/// The remaining leaves, with areas that somebody else measures: after every merge, and, for every merge whose cost is computed, all areas
/// that it can change. This is the paper's own way, with N_l + 1 passes a view; LiveVisibility gets the same from lists. Has the members of
/// that which Collapse uses, but merges are evaluated one after the other. If measuring fails, areas stay and failure() says why: the
/// collapse goes on, quickly, and its result is worth nothing.
class MeasuredVisibility : public LeafAreas {
 public:
  static constexpr bool kOneAtATime = true;
  struct Scratch {};
  struct OwnedPixels {};

  /// foliage  as render_item_buffers checks it; views  over its bounding sphere
  MeasuredVisibility(const Foliage& foliage, const std::vector<Viewpoint>& views, std::uint32_t resolution_px, const MeasureAreas& measure)
      : LeafAreas(foliage, views.size()), resolution_px_(resolution_px), measure_(measure), live_(foliage.leaf_count()) {
    const Sphere sphere = bounding_sphere(foliage);
    for (const Viewpoint& view : views) projections_.push_back(make_projection(view, sphere, resolution_px));
    std::iota(live_.begin(), live_.end(), 0u);
    const std::vector<std::uint32_t> px = measured(live_, {});
    const auto background_px = px.end() - static_cast<std::ptrdiff_t>(views.size());
    std::copy(px.begin(), background_px, areas_px_.begin());
    std::copy_backward(background_px, px.end(), areas_px_.end());
  }

  [[nodiscard]] const Result<void>& failure() const { return failure_; }
  [[nodiscard]] std::uint32_t pixels_per_view() const { return resolution_px_ * resolution_px_; }
  void owned_pixels(std::uint32_t, OwnedPixels&) const {}

  /// Measures the areas after the merge.
  void changes_of(const LeafMerge& merge, const OwnedPixels&, Scratch&, AreaChanges& changes) {
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

  void apply(const LeafMerge& merge, const AreaChanges& changes) {
    leaves_[merge.result] = merge.leaf;
    std::erase(live_, merge.first);
    std::erase(live_, merge.second);
    live_.push_back(merge.result);
    for (std::uint32_t v = 0; v < view_count(); ++v) add_changes(changes, v);
  }

 private:
  /// returns  [(ids.size() + 1) * view_count] row per leaf, the background's last, px
  std::vector<std::uint32_t> measured(const std::vector<std::uint32_t>& ids, std::span<const PixelBox> changed) {
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

  std::uint32_t resolution_px_;
  std::vector<Projection> projections_;  ///< [view]
  const MeasureAreas& measure_;
  std::vector<std::uint32_t> live_;  ///< ascending
  Result<void> failure_;
};

struct Candidate {
  LeafMerge merge;
  PairCorners corners{};
  AreaChanges changes;
  FixedBits cost = 0;
};

template <class Visibility>
struct Scratch {
  typename Visibility::Scratch visibility;
  std::vector<std::uint32_t> row;
  std::vector<std::uint32_t> change_of;  ///< [outcome] index into the changes; kNone between calls
};

/// Visibility  LiveVisibility or MeasuredVisibility
template <class Visibility>
class Collapse {
 public:
  Collapse(const Foliage& foliage, const CollapseOptions& options, Visibility visibility)
      : options_(options),
        visibility_(std::move(visibility)),
        octree_(foliage, visibility_.id_count()),
        information_(visibility_.id_count() + 1, 0),
        next_id_(foliage.leaf_count()) {
    for (std::uint32_t id = 0; id < foliage.leaf_count(); ++id) {
      ranking_.insert({0, id});
      octree_.insert(id, quad_centroid(foliage.quads[id]));
    }
    refresh_all();
  }

  [[nodiscard]] FixedBits foliage_information() const { return foliage_information_; }
  [[nodiscard]] std::uint64_t evaluations() const { return evaluations_; }
  [[nodiscard]] const Visibility& visibility() const { return visibility_; }

  Merge step() {
    const std::uint32_t chosen = ranking_.begin()->second;
    octree_.cell_candidates_of(chosen, options_.candidate_count, partners_);
    if (candidates_.size() < partners_.size()) candidates_.resize(partners_.size());
    visibility_.owned_pixels(chosen, chosen_owned_);
    const auto weigh_one = [&](std::size_t i) { weigh(chosen, partners_[i], candidates_[i]); };
    if constexpr (Visibility::kOneAtATime)
      for (std::size_t i = 0; i < partners_.size(); ++i) weigh_one(i);
    else
      parallel_for(partners_.size(), weigh_one);
    evaluations_ += partners_.size();
    std::size_t best = 0;
    for (std::size_t i = 1; i < partners_.size(); ++i) {
      const FixedBits difference = candidates_[i].cost - candidates_[best].cost;
      if (difference < 0 || (difference == 0 && partners_[i] < partners_[best])) best = i;
    }
    return commit(candidates_[best], chosen, partners_[best]);
  }

 private:
  /// a_t of every view, given the background's areas.
  [[nodiscard]] ViewTotals totals_of(std::span<const std::uint32_t> background_px) const {
    return view_totals(background_px, visibility_.pixels_per_view(), options_.count_background);
  }

  [[nodiscard]] bool counts(std::uint32_t outcome) const { return options_.count_background || outcome != visibility_.background(); }

  void weigh(std::uint32_t chosen, std::uint32_t partner, Candidate& candidate) {
    Scratch<Visibility>& scratch = scratches_.local();
    // Corners and card belong to the pair in id order, whichever of the two was chosen.
    const LiveLeaf& first = visibility_.leaf(std::min(chosen, partner));
    const LiveLeaf& second = visibility_.leaf(std::max(chosen, partner));
    candidate.corners = merge_corners(first.quad, second.quad);
    candidate.merge = {chosen, partner, next_id_, merged_leaf(first, second, candidate.corners)};
    visibility_.changes_of(candidate.merge, chosen_owned_, scratch.visibility, candidate.changes);
    const FixedBits change = totals_change(candidate.changes) ? change_of_all(candidate, scratch) : change_of_touched(candidate, scratch);
    candidate.cost = std::abs(change);
  }

  /// Whether a merge changes a_t of some view, and with it every p(l|v) there.
  [[nodiscard]] bool totals_change(const AreaChanges& changes) const {
    return !options_.count_background && changes.touch(visibility_.background(), visibility_.view_count());
  }

  /// The outcome's areas after the i-th change; they lie in scratch.row.
  std::span<const std::uint32_t> changed_row(const AreaChanges& changes, std::size_t i, Scratch<Visibility>& scratch) const {
    visibility_.areas_after(changes.outcomes[i], changes.row(i, visibility_.view_count()), scratch.row);
    return scratch.row;
  }

  /// The outcome's present areas; they lie in `row`.
  std::span<const std::uint32_t> row_of(std::uint32_t outcome, std::vector<std::uint32_t>& row) const {
    visibility_.areas_after(outcome, {}, row);
    return row;
  }

  /// I(V,L') - I(V,L) if no a_t changes: only outcomes with changed areas contribute.
  FixedBits change_of_touched(const Candidate& candidate, Scratch<Visibility>& scratch) const {
    FixedBits change = -information_[candidate.merge.first] - information_[candidate.merge.second];
    for (std::size_t i = 0; i < candidate.changes.outcomes.size(); ++i) {
      const std::uint32_t outcome = candidate.changes.outcomes[i];
      if (counts(outcome)) change += outcome_information(changed_row(candidate.changes, i, scratch), totals_) - information_[outcome];
    }
    return change;
  }

  /// The same if some a_t changes: then every leaf's share of that view changes.
  FixedBits change_of_all(const Candidate& candidate, Scratch<Visibility>& scratch) const {
    const AreaChanges& changes = candidate.changes;
    scratch.change_of.resize(information_.size(), kNone);
    for (std::size_t i = 0; i < changes.outcomes.size(); ++i) scratch.change_of[changes.outcomes[i]] = static_cast<std::uint32_t>(i);
    const ViewTotals totals = totals_of(changed_row(changes, scratch.change_of[visibility_.background()], scratch));

    const auto information_after = [&](std::uint32_t outcome) {
      const std::uint32_t i = scratch.change_of[outcome];
      return outcome_information(i == kNone ? row_of(outcome, scratch.row) : changed_row(changes, i, scratch), totals);
    };
    FixedBits after = scratch.change_of[candidate.merge.result] == kNone ? 0 : information_after(candidate.merge.result);
    for (const auto& [bits, id] : ranking_)
      if (id != candidate.merge.first && id != candidate.merge.second) after += information_after(id);
    for (const std::uint32_t outcome : changes.outcomes) scratch.change_of[outcome] = kNone;
    return after - foliage_information_;
  }

  Merge commit(const Candidate& candidate, std::uint32_t chosen, std::uint32_t partner) {
    const bool all_change = totals_change(candidate.changes);
    visibility_.apply(candidate.merge, candidate.changes);
    for (const std::uint32_t removed : {chosen, partner}) {
      octree_.remove(removed);
      ranking_.erase({information_[removed], removed});
      foliage_information_ -= information_[removed];
      information_[removed] = 0;
    }
    octree_.insert(next_id_, quad_centroid(candidate.merge.leaf.quad));
    ranking_.insert({0, next_id_++});
    if (all_change) {
      refresh_all();
    } else {
      for (const std::uint32_t outcome : candidate.changes.outcomes) refresh(outcome);
    }
    return {std::min(chosen, partner), std::max(chosen, partner), candidate.corners};
  }

  void refresh(std::uint32_t outcome) {
    if (!counts(outcome)) return;
    const FixedBits before = information_[outcome];
    information_[outcome] = outcome_information(row_of(outcome, row_), totals_);
    foliage_information_ += information_[outcome] - before;
    if (outcome == visibility_.background()) return;
    ranking_.erase({before, outcome});
    ranking_.insert({information_[outcome], outcome});
  }

  void refresh_all() {
    totals_ = totals_of(row_of(visibility_.background(), row_));
    for (const auto& [bits, id] : std::exchange(ranking_, {})) refresh(id);
    refresh(visibility_.background());
  }

  CollapseOptions options_;
  Visibility visibility_;
  LeafOctree octree_;
  ViewTotals totals_;
  std::vector<FixedBits> information_;                     ///< [outcome] I(V,l), 0 if not live
  FixedBits foliage_information_ = 0;                      ///< I(V,L)
  std::set<std::pair<FixedBits, std::uint32_t>> ranking_;  ///< (I(V,l), id) of live leaves: of equals the smaller id comes first
  std::uint32_t next_id_ = 0;
  std::uint64_t evaluations_ = 0;
  std::vector<std::uint32_t> partners_;
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> row_;
  typename Visibility::OwnedPixels chosen_owned_;
  tbb::enumerable_thread_specific<Scratch<Visibility>> scratches_;
};

Result<LiveVisibility> live_visibility(const ShownFoliage& shown, const std::vector<Viewpoint>& views, std::uint32_t resolution_px,
                                       const MeasureAreas& measure) {
  COPPICE_TRY(visibility, LiveVisibility::create(shown, views, resolution_px));
  if (!measure) return visibility;
  std::vector<std::uint32_t> areas_px((std::size_t{shown.foliage.leaf_count()} + 1) * views.size());
  COPPICE_CHECK(measure({shown.foliage.quads, shown.foliage.cards, {}}, areas_px));
  visibility.correct(areas_px);
  return visibility;
}

}  // namespace

Result<CollapseResult> collapse_by_mutual_information(const ShownFoliage& shown, const std::vector<Viewpoint>& views,
                                                      const CollapseOptions& options, const ProgressFunction& progress,
                                                      const AreaSource& areas) {
  COPPICE_CHECK(check_candidate_count(options));
  Stopwatch watch;
  CollapseResult result;
  const std::uint32_t leaf_count = shown.foliage.leaf_count();
  if (areas.measure && areas.every_step) {
    COPPICE_CHECK(check_shown(shown, views, options.resolution_px));
    MeasuredVisibility visibility(shown.foliage, views, options.resolution_px, areas.measure);
    result.visibility_seconds = watch.lap();
    Collapse collapse(shown.foliage, options, std::move(visibility));
    collapse_down(collapse, leaf_count, progress, result);
    COPPICE_CHECK(collapse.visibility().failure());
  } else {
    COPPICE_TRY(visibility, live_visibility(shown, views, options.resolution_px, areas.measure));
    result.visibility_seconds = watch.lap();
    Collapse collapse(shown.foliage, options, std::move(visibility));
    collapse_down(collapse, leaf_count, progress, result);
  }
  return result;
}

}  // namespace coppice::bake
