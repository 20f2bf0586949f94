#pragma once

// Item buffers that follow the collapse: they compute what a merge would change, and change it, exactly.
//
// A merge removes two leaves and adds one, so it changes the front leaf only where the two were in front and where the new one will be.
// Both sets are walked pixel by pixel. First every pixel of the removed leaves passes to the next leaf in its list (or the background).
// Then the new leaf takes each pixel that it covers from its present owner, if the new leaf is nearer. The sums are integers.

#include <algorithm>

#include "alpha_mask.h"
#include "fragment_lists.h"
#include "plant.h"
#include "quad_merge.h"
#include "result.h"
#include "visibility.h"

namespace coppice::bake {

/// A live leaf, source or merged.
struct LiveLeaf {
  Quad quad{};
  std::uint32_t card = 0;
  // Only IncrementalImage reads these.
  std::uint8_t opacity = kOpaque;
  std::uint16_t normals = kFlatNormals;  ///< a merged leaf has its rounded normal_sum
  NormalSum normal_sum{};
};

/// The leaf that a pair becomes: its quad has the pair's `corners`, its card is the larger leaf's.
[[nodiscard]] LiveLeaf merged_leaf(const LiveLeaf& first, const LiveLeaf& second, const PairCorners& corners);

/// What leaves show, with its holes.
struct MaskedCards {
  std::vector<Card> table;
  std::vector<AlphaMask> masks;  ///< [material]
};

/// Calls visit(pixel, fragment) for every pixel that a leaf covers in a view, in front or not.
template <class Visit>
void for_each_fragment(const Projection& projection, const MaskedCards& cards, const LiveLeaf& leaf, std::uint32_t id, Visit&& visit) {
  const std::int32_t width = projection.resolution_px;
  const Card& card = cards.table[leaf.card];
  rasterise_leaf(project(projection, leaf.quad), card, cards.masks[card.material], width,
                 [&](const QuadFragment& f) { visit(static_cast<std::uint32_t>(f.y * width + f.x), make_fragment(f.depth, id)); });
}

/// Two live leaves and the leaf that replaces them.
struct LeafMerge {
  std::uint32_t first = 0, second = 0;
  std::uint32_t result = 0;  ///< id; not live, larger than every live id
  LiveLeaf leaf;             ///< the result
};

/// How a merge changes areas. The removed leaves are not listed, since their areas become 0.
struct AreaChanges {
  std::vector<std::uint32_t> outcomes;  ///< distinct; the merged leaf and the background may be among them
  std::vector<std::int32_t> delta_px;   ///< [outcomes.size() * view_count] row per outcome

  [[nodiscard]] std::span<const std::int32_t> row(std::size_t i, std::uint32_t view_count) const {
    return std::span(delta_px).subspan(i * view_count, view_count);
  }
  /// Whether an outcome's area changes in some view.
  [[nodiscard]] bool touch(std::uint32_t outcome, std::uint32_t view_count) const {
    const auto found = std::ranges::find(outcomes, outcome);
    return found != outcomes.end() && std::ranges::any_of(row(static_cast<std::size_t>(found - outcomes.begin()), view_count),
                                                          [](std::int32_t delta) { return delta != 0; });
  }
};

/// The leaves of a collapse, and what each outcome covers in each view. Ids: N source leaves, then merge results. A leaf's outcome is its
/// id; the background's follows the last one.
class LeafAreas {
 public:
  LeafAreas(const Foliage& foliage, std::size_t view_count)
      : view_count_(static_cast<std::uint32_t>(view_count)),
        id_count_(2 * foliage.leaf_count() - 1),
        leaves_(id_count_),
        areas_px_((leaves_.size() + 1) * view_count, 0) {
    for (std::uint32_t i = 0; i < foliage.leaf_count(); ++i) leaves_[i] = {.quad = foliage.quads[i], .card = foliage.cards[i]};
  }

  [[nodiscard]] std::uint32_t view_count() const { return view_count_; }
  /// All ids are below it.
  [[nodiscard]] std::uint32_t id_count() const { return id_count_; }
  [[nodiscard]] std::uint32_t background() const { return id_count_; }
  [[nodiscard]] const LiveLeaf& leaf(std::uint32_t id) const { return leaves_[id]; }
  /// [view_count] px; 0 for ids that are not live.
  [[nodiscard]] std::span<const std::uint32_t> areas(std::uint32_t outcome) const {
    return std::span(areas_px_).subspan(std::size_t{outcome} * view_count_, view_count_);
  }
  /// The areas of a live outcome after a change.
  /// delta_px  [view_count]; empty: no change
  /// row       receives [view_count] px
  void areas_after(std::uint32_t outcome, std::span<const std::int32_t> delta_px, std::vector<std::uint32_t>& row) const {
    row.assign(areas(outcome).begin(), areas(outcome).end());
    for (std::size_t v = 0; v < delta_px.size(); ++v) row[v] += static_cast<std::uint32_t>(delta_px[v]);
  }

 protected:
  [[nodiscard]] std::uint32_t outcome_of(LeafFragment fragment) const {
    return fragment == kNothing ? background() : fragment_leaf(fragment);
  }
  [[nodiscard]] std::uint32_t& area_px(std::uint32_t outcome, std::uint32_t v) { return areas_px_[std::size_t{outcome} * view_count_ + v]; }
  void add_changes(const AreaChanges& changes, std::uint32_t v) {
    for (std::size_t i = 0; i < changes.outcomes.size(); ++i)
      area_px(changes.outcomes[i], v) += static_cast<std::uint32_t>(changes.row(i, view_count_)[v]);
  }

  std::uint32_t view_count_, id_count_;
  std::vector<LiveLeaf> leaves_;         ///< [id_count]
  std::vector<std::uint32_t> areas_px_;  ///< [(id_count + 1) * view_count] row per outcome
};

/// The pixels in which a leaf is in front, view by view, and what would be in front there without it.
struct OwnedPixels {
  struct Pixel {
    std::uint32_t pixel = 0;
    LeafFragment behind = 0;
  };
  std::vector<std::uint32_t> view_begin;  ///< [view_count + 1]
  std::vector<Pixel> pixels;
};

class LiveVisibility : public LeafAreas {
 public:
  static constexpr bool kOneAtATime = false;  ///< merges may be evaluated in parallel
  using OwnedPixels = bake::OwnedPixels;
  /// Working memory of one thread.
  struct Scratch {
    std::vector<std::uint32_t> slot;  ///< [outcome] its row in the AreaChanges being built; kNone between calls
    OwnedPixels owned;
    std::vector<LeafFragment> rest;  ///< [pixel] of one view: what is in front without the two leaves; set where one of them is
  };

  /// Starts with all leaves. errors  those of render_item_buffers
  static Result<LiveVisibility> create(const ShownFoliage& shown, const std::vector<Viewpoint>& views, std::uint32_t resolution_px);

  /// Adopts areas of the same leaves that somebody else has measured. From now on areas_after() adds the difference between these and the
  /// present ones, as far as the sum is a number of pixels of the view.
  /// measured_px  [(leaf_count + 1) * view_count] row per leaf, the background's last
  void correct(std::span<const std::uint32_t> measured_px);

  [[nodiscard]] std::uint32_t pixels_per_view() const { return pixels_per_view_; }
  /// As LeafAreas::areas_after, with corrections if correct() has been called. areas() has none.
  void areas_after(std::uint32_t outcome, std::span<const std::int32_t> delta_px, std::vector<std::uint32_t>& row) const;

  void owned_pixels(std::uint32_t id, OwnedPixels& owned) const;

  /// Computes what a merge would change. May run on several threads, each with its own scratch and changes.
  /// first_owned  owned_pixels(merge.first) of the same state: shared by all partners of a leaf
  void changes_of(const LeafMerge& merge, const OwnedPixels& first_owned, Scratch& scratch, AreaChanges& changes) const;

  /// Does a merge. changes  changes_of(merge) in the same state. Parallel over views.
  void apply(const LeafMerge& merge, const AreaChanges& changes);

 private:
  struct View {
    Projection projection;
    PixelLists<LeafFragment> fragments;
  };

  LiveVisibility(const Foliage& foliage, std::vector<AlphaMask> masks, const std::vector<Viewpoint>& views, const ItemBuffers& buffers);
  class ChangeWriter;
  void release(std::uint32_t v, const LeafMerge& merge, const OwnedPixels& owned, Scratch& scratch, ChangeWriter& writer) const;
  void add(std::uint32_t v, const LeafMerge& merge, const Scratch& scratch, ChangeWriter& writer) const;

  std::uint32_t pixels_per_view_ = 0;
  MaskedCards cards_;
  std::vector<View> views_;
  std::vector<std::int32_t> corrections_px_;  ///< [(id_count + 1) * view_count] from correct(); empty: none
};

}  // namespace coppice::bake
