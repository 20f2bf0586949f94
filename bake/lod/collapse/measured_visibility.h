#pragma once

// The remaining leaves, with areas that somebody else measures: after every merge, and, for every merge whose cost is computed, all areas
// that it can change. This is the paper's own way, with N_l + 1 passes a view; live_visibility.h gets the same from lists.

#include <cstdint>
#include <span>
#include <vector>

#include "area_request.h"
#include "live_visibility.h"
#include "plant.h"
#include "visibility.h"

namespace coppice::bake {

/// Has the members of LiveVisibility that Collapse uses, but merges are evaluated one after the other. If measuring fails, areas stay and
/// failure() says why: the collapse goes on, quickly, and its result is worth nothing.
class MeasuredVisibility {
 public:
  static constexpr bool kOneAtATime = true;
  struct Scratch {};
  struct OwnedPixels {};

  /// foliage  as render_item_buffers checks it; views  over its bounding sphere
  MeasuredVisibility(const Foliage& foliage, const std::vector<Viewpoint>& views, std::uint32_t resolution_px, MeasureAreas measure);

  [[nodiscard]] const Result<void>& failure() const { return failure_; }
  [[nodiscard]] std::uint32_t view_count() const { return static_cast<std::uint32_t>(projections_.size()); }
  [[nodiscard]] std::uint32_t pixels_per_view() const { return resolution_px_ * resolution_px_; }
  [[nodiscard]] std::uint32_t id_count() const { return static_cast<std::uint32_t>(leaves_.size()); }
  [[nodiscard]] std::uint32_t background() const { return id_count(); }
  [[nodiscard]] const LiveLeaf& leaf(std::uint32_t id) const { return leaves_[id]; }
  /// As LiveVisibility::areas_after.
  void areas_after(std::uint32_t outcome, std::span<const std::int32_t> delta_px, std::vector<std::uint32_t>& row) const;

  void owned_pixels(std::uint32_t, OwnedPixels&) const {}
  /// Measures the areas after the merge.
  void changes_of(const LeafMerge& merge, const OwnedPixels&, Scratch&, AreaChanges& changes);
  void apply(const LeafMerge& merge, const AreaChanges& changes);

 private:
  /// [view_count] px
  [[nodiscard]] std::span<const std::uint32_t> areas(std::uint32_t outcome) const {
    return std::span(areas_px_).subspan(std::size_t{outcome} * view_count(), view_count());
  }
  /// returns  [(ids.size() + 1) * view_count] row per leaf, the background's last, px
  std::vector<std::uint32_t> measured(const std::vector<std::uint32_t>& ids, std::span<const PixelBox> changed);

  std::uint32_t resolution_px_ = 0;
  std::vector<Projection> projections_;  ///< [view]
  MeasureAreas measure_;
  std::vector<LiveLeaf> leaves_;         ///< [id]
  std::vector<std::uint32_t> live_;      ///< ascending
  std::vector<std::uint32_t> areas_px_;  ///< [(id_count + 1) * view_count] row per outcome
  Result<void> failure_;
};

}  // namespace coppice::bake
