#include "replay.h"

#include <chrono>
#include <utility>

#include "alpha_mask.h"
#include "collapse_down.h"
#include "live_visibility.h"
#include "mutual_information.h"
#include "quad_merge.h"

namespace coppice::bake {
namespace {

FixedBits information_of(const LiveVisibility& visibility, bool count_background) {
  ViewTotals totals(visibility.view_count());
  const auto background_px = visibility.areas(visibility.background());
  for (std::uint32_t view = 0; view < visibility.view_count(); ++view)
    totals.set(view, count_background ? visibility.pixels_per_view() : visibility.pixels_per_view() - background_px[view]);
  FixedBits sum = count_background ? outcome_information(background_px, totals) : 0;
  for (std::uint32_t id = 0; id < visibility.id_count(); ++id) sum += outcome_information(visibility.areas(id), totals);
  return sum;
}

LeafMerge leaf_merge(const LiveVisibility& visibility, const Merge& merge, std::uint32_t result) {
  const LiveLeaf& first = visibility.leaf(merge.first);
  const LiveLeaf& second = visibility.leaf(merge.second);
  return {merge.first,
          merge.second,
          result,
          {merged_quad(first.quad, second.quad, merge.corners), merged_card(first.quad, first.card, second.quad, second.card)}};
}

/// Does a sequence's merges in order.
class Replay {
 public:
  Replay(LiveVisibility visibility, const CollapseSequence& sequence, std::uint32_t leaf_count, bool count_background)
      : visibility_(std::move(visibility)), sequence_(sequence), leaf_count_(leaf_count), count_background_(count_background) {}

  [[nodiscard]] FixedBits foliage_information() const { return information_of(visibility_, count_background_); }

  Merge step() {
    const Merge& next = sequence_.merges[done_];
    const LeafMerge merge = leaf_merge(visibility_, next, leaf_count_ + done_);
    visibility_.owned_pixels(merge.first, owned_);
    visibility_.changes_of(merge, owned_, scratch_, changes_);
    visibility_.apply(merge, changes_);
    ++done_;
    return next;
  }

 private:
  LiveVisibility visibility_;
  const CollapseSequence& sequence_;
  std::uint32_t leaf_count_ = 0, done_ = 0;
  bool count_background_ = true;
  LiveVisibility::Scratch scratch_;
  OwnedPixels owned_;
  AreaChanges changes_;
};

}  // namespace

Result<CollapseResult> replay(const ShownFoliage& shown, const std::vector<Viewpoint>& views, const CollapseOptions& options,
                              const CollapseSequence& sequence) {
  const auto start = std::chrono::steady_clock::now();
  COPPICE_TRY(buffers, render_item_buffers(shown, views, options.resolution_px));
  COPPICE_TRY(masks, alpha_masks(shown.materials, shown.images));
  LiveVisibility visibility(shown.foliage, std::move(masks), views, buffers);
  CollapseResult result;
  result.visibility_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  Replay collapse(std::move(visibility), sequence, shown.foliage.leaf_count(), options.count_background);
  collapse_down(collapse, shown.foliage.leaf_count(), {}, result);
  result.sequence.evaluations = sequence.evaluations;
  return result;
}

}  // namespace coppice::bake
