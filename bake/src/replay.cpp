#include "replay.h"

#include <chrono>
#include <utility>

#include "live_visibility.h"
#include "mutual_information.h"
#include "quad_merge.h"

namespace coppice::bake {
namespace {

FoliageInformation information_of(const LiveVisibility& visibility, std::uint32_t live_count, bool count_background) {
  ViewTotals totals(visibility.view_count());
  const auto background_px = visibility.areas(visibility.background());
  for (std::uint32_t view = 0; view < visibility.view_count(); ++view)
    totals.set(view, count_background ? visibility.pixels_per_view() : visibility.pixels_per_view() - background_px[view]);
  FixedBits sum = count_background ? outcome_information(background_px, totals) : 0;
  for (std::uint32_t id = 0; id < visibility.id_count(); ++id) sum += outcome_information(visibility.areas(id), totals);
  return {live_count, to_bits(sum)};
}

LeafMerge leaf_merge(const LiveVisibility& visibility, const Merge& merge, std::uint32_t result) {
  const LiveLeaf& first = visibility.leaf(merge.first);
  const LiveLeaf& second = visibility.leaf(merge.second);
  return {merge.first,
          merge.second,
          result,
          {merged_quad(first.quad, second.quad, merge.corners), merged_card(first.quad, first.card, second.quad, second.card)}};
}

}  // namespace

Result<CollapseResult> replay(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                              const std::vector<Viewpoint>& views, const CollapseOptions& options, CollapseSequence sequence) {
  const auto start = std::chrono::steady_clock::now();
  COPPICE_TRY(buffers, render_item_buffers(foliage, materials, images, views, options.resolution_px));
  COPPICE_TRY(masks, alpha_masks(materials, images));
  LiveVisibility visibility(foliage, std::move(masks), views, buffers);
  CollapseResult result;
  result.visibility_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  const std::uint32_t leaf_count = foliage.leaf_count();
  const std::vector<std::uint32_t> levels = level_leaf_counts(leaf_count);
  const auto record_levels = [&](std::uint32_t live_count) {
    while (result.levels.size() < levels.size() && levels[result.levels.size()] == live_count)
      result.levels.push_back(information_of(visibility, live_count, options.count_background));
  };
  result.source = information_of(visibility, leaf_count, options.count_background);
  record_levels(leaf_count);
  LiveVisibility::Scratch scratch;
  OwnedPixels owned;
  AreaChanges changes;
  for (std::uint32_t i = 0; i < sequence.merges.size(); ++i) {
    const LeafMerge merge = leaf_merge(visibility, sequence.merges[i], leaf_count + i);
    visibility.owned_pixels(merge.first, owned);
    visibility.changes_of(merge, owned, scratch, changes);
    visibility.apply(merge, changes);
    record_levels(leaf_count - 1 - i);
  }
  result.sequence = std::move(sequence);
  return result;
}

}  // namespace coppice::bake
