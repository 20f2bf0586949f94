#include "live_visibility.h"

#include <utility>

#include "bounds.h"
#include "parallel_for.h"

namespace coppice::bake {

LiveLeaf merged_leaf(const LiveLeaf& first, const LiveLeaf& second, const PairCorners& corners) {
  return {.quad = merged_quad(first.quad, second.quad, corners), .card = merged_card(first.quad, first.card, second.quad, second.card)};
}

/// Adds up changes in one row per outcome, found through the scratch's slots.
class LiveVisibility::ChangeWriter {
 public:
  ChangeWriter(std::uint32_t view_count, std::uint32_t outcome_count, Scratch& scratch, AreaChanges& changes)
      : view_count_(view_count), scratch_(scratch), changes_(changes) {
    scratch.slot.resize(outcome_count, kNone);
    changes.outcomes.clear();
    changes.delta_px.clear();
  }
  ChangeWriter(const ChangeWriter&) = delete;
  ChangeWriter& operator=(const ChangeWriter&) = delete;
  ~ChangeWriter() {
    for (const std::uint32_t outcome : changes_.outcomes) scratch_.slot[outcome] = kNone;
  }

  void add(std::uint32_t outcome, std::uint32_t view, std::int32_t change_px) {
    if (outcome != last_outcome_) find_row(outcome);
    changes_.delta_px[last_row_ + view] += change_px;
  }

 private:
  void find_row(std::uint32_t outcome) {
    std::uint32_t& slot = scratch_.slot[outcome];
    if (slot == kNone) {
      slot = static_cast<std::uint32_t>(changes_.outcomes.size());
      changes_.outcomes.push_back(outcome);
      changes_.delta_px.resize(changes_.delta_px.size() + view_count_, 0);
    }
    last_outcome_ = outcome;
    last_row_ = std::size_t{slot} * view_count_;
  }

  std::uint32_t last_outcome_ = kNone;  ///< neighbouring pixels mostly change the same leaf's area
  std::size_t last_row_ = 0;
  std::uint32_t view_count_;
  Scratch& scratch_;
  AreaChanges& changes_;
};

LiveVisibility::LiveVisibility(const Foliage& foliage, std::vector<AlphaMask> masks, const std::vector<Viewpoint>& views,
                               const ItemBuffers& buffers)
    : LeafAreas(foliage, buffers.view_count),
      pixels_per_view_(buffers.pixels_per_view()),
      cards_{foliage.card_table, std::move(masks)},
      views_(buffers.view_count) {
  const Sphere sphere = bounding_sphere(foliage);
  parallel_for(view_count_, [&](std::uint32_t v) {
    View& view = views_[v];
    view.projection = make_projection(views[v], sphere, buffers.resolution_px);
    view.fragments = PixelLists<LeafFragment>(buffers, v, [](LeafFragment fragment) { return fragment; });
    for (std::uint32_t pixel = 0; pixel < pixels_per_view_; ++pixel) ++area_px(outcome_of(view.fragments.front(pixel)), v);
  });
}

Result<LiveVisibility> LiveVisibility::create(const ShownFoliage& shown, const std::vector<Viewpoint>& views, std::uint32_t resolution_px) {
  COPPICE_TRY(buffers, render_item_buffers(shown, views, resolution_px));
  COPPICE_TRY(masks, alpha_masks(shown.materials, shown.images));
  return LiveVisibility(shown.foliage, std::move(masks), views, buffers);
}

void LiveVisibility::correct(std::span<const std::uint32_t> measured_px) {
  corrections_px_.assign(areas_px_.size(), 0);
  const std::size_t background_at = measured_px.size() - view_count_;
  for (std::size_t i = 0; i < measured_px.size(); ++i) {
    const std::size_t at = i < background_at ? i : areas_px_.size() - measured_px.size() + i;
    corrections_px_[at] = static_cast<std::int32_t>(measured_px[i] - areas_px_[at]);
  }
}

void LiveVisibility::areas_after(std::uint32_t outcome, std::span<const std::int32_t> delta_px, std::vector<std::uint32_t>& row) const {
  LeafAreas::areas_after(outcome, delta_px, row);
  if (corrections_px_.empty()) return;
  for (std::size_t v = 0; v < row.size(); ++v) {
    const std::int32_t corrected_px = static_cast<std::int32_t>(row[v]) + corrections_px_[std::size_t{outcome} * view_count_ + v];
    row[v] = static_cast<std::uint32_t>(std::clamp(corrected_px, 0, static_cast<std::int32_t>(pixels_per_view_)));
  }
}

void LiveVisibility::owned_pixels(std::uint32_t id, OwnedPixels& owned) const {
  owned.pixels.clear();
  owned.view_begin.assign(1, 0);
  for (std::uint32_t v = 0; v < view_count_; ++v) {
    if (areas(id)[v] > 0) {
      const View& view = views_[v];
      const std::int32_t width = view.projection.resolution_px;
      for_each_run(RasterQuad(project(view.projection, leaves_[id].quad)), width, [&](const PixelRun& run) {
        const auto row = static_cast<std::uint32_t>(run.y * width);
        for (std::uint32_t pixel = row + static_cast<std::uint32_t>(run.first); pixel <= row + static_cast<std::uint32_t>(run.last);
             ++pixel)
          if (fragment_leaf(view.fragments.front(pixel)) == id) owned.pixels.push_back({pixel, view.fragments.behind(pixel)});
      });
    }
    owned.view_begin.push_back(static_cast<std::uint32_t>(owned.pixels.size()));
  }
}

/// Passes the pixels of one of the pair to the nearest leaf behind both.
void LiveVisibility::release(std::uint32_t v, const LeafMerge& merge, const OwnedPixels& owned, Scratch& scratch,
                             ChangeWriter& writer) const {
  for (std::uint32_t i = owned.view_begin[v]; i < owned.view_begin[v + 1]; ++i) {
    auto [pixel, rest] = owned.pixels[i];
    if (fragment_leaf(rest) == merge.first || fragment_leaf(rest) == merge.second)
      rest = views_[v].fragments.front_without(pixel, merge.first, merge.second);
    scratch.rest[pixel] = rest;
    writer.add(outcome_of(rest), v, 1);
  }
}

/// Gives the merged leaf the pixels where it is nearer than the rest. Its id is the largest, so at equal depths it is behind.
void LiveVisibility::add(std::uint32_t v, const LeafMerge& merge, const Scratch& scratch, ChangeWriter& writer) const {
  const View& view = views_[v];
  const std::int32_t width = view.projection.resolution_px;
  const Card& card = cards_.table[merge.leaf.card];
  const AlphaMask& mask = cards_.masks[card.material];
  const auto shows = [&](const RasterTriangle& triangle, std::uint32_t index, std::int32_t x, std::int32_t y) {
    return mask.hole.empty() || !mask.is_hole(card_uv(triangle, index, card, x, y));
  };
  std::int32_t gained_px = 0;
  const RasterQuad quad(project(view.projection, merge.leaf.quad));
  for_each_run(quad, width, [&](const PixelRun& run) {
    const RasterTriangle& triangle = quad.triangles[run.triangle];
    const DepthRow depths = triangle.depths(run.y), other_depths = quad.triangles[1].depths(run.y);
    for (std::int32_t x = run.first; x <= run.last; ++x) {
      const auto pixel = static_cast<std::uint32_t>(run.y * width + x);
      LeafFragment rest = view.fragments.front(pixel);
      if (fragment_leaf(rest) == merge.first || fragment_leaf(rest) == merge.second) rest = scratch.rest[pixel];
      const std::uint32_t depth = fragment_depth(rest);
      const bool gains = (depths.is_nearer(x, depth) && shows(triangle, run.triangle, x, run.y)) ||
                         (run.folded && other_depths.is_nearer(x, depth) && shows(quad.triangles[1], 1, x, run.y));
      if (!gains) continue;
      writer.add(outcome_of(rest), v, -1);
      ++gained_px;
    }
  });
  if (gained_px > 0) writer.add(merge.result, v, gained_px);
}

void LiveVisibility::changes_of(const LeafMerge& merge, const OwnedPixels& first_owned, Scratch& scratch, AreaChanges& changes) const {
  ChangeWriter writer(view_count_, id_count() + 1, scratch, changes);
  scratch.rest.resize(pixels_per_view_);
  owned_pixels(merge.second, scratch.owned);
  for (std::uint32_t v = 0; v < view_count_; ++v) {
    release(v, merge, first_owned, scratch, writer);
    release(v, merge, scratch.owned, scratch, writer);
    add(v, merge, scratch, writer);
  }
}

void LiveVisibility::apply(const LeafMerge& merge, const AreaChanges& changes) {
  leaves_[merge.result] = merge.leaf;
  parallel_for(view_count_, [&](std::uint32_t v) {
    View& view = views_[v];
    for (const std::uint32_t removed : {merge.first, merge.second}) {
      for_each_fragment(view.projection, cards_, leaves_[removed], removed,
                        [&](std::uint32_t pixel, LeafFragment f) { view.fragments.remove(pixel, f); });
      area_px(removed, v) = 0;
    }
    for_each_fragment(view.projection, cards_, merge.leaf, merge.result,
                      [&](std::uint32_t pixel, LeafFragment f) { view.fragments.insert(pixel, f); });
    add_changes(changes, v);
  });
}

}  // namespace coppice::bake
