#pragma once

// What all collapses share.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "collapse.h"
#include "mutual_information.h"
#include "progress.h"

namespace coppice::bake {

/// I(V,L) of the live leaves, and of the background if it counts.
/// visibility  has the areas of each outcome: LiveVisibility, IncrementalImage
template <class Visibility>
[[nodiscard]] FixedBits foliage_information(const Visibility& visibility, bool count_background) {
  const std::span<const std::uint32_t> background_px = visibility.areas(visibility.background());
  const ViewTotals totals = view_totals(background_px, visibility.pixels_per_view(), count_background);
  FixedBits sum = count_background ? outcome_information(background_px, totals) : 0;
  for (std::uint32_t id = 0; id < visibility.id_count(); ++id) sum += outcome_information(visibility.areas(id), totals);
  return sum;
}

/// Steps a collapse down to one leaf. Fills result.source, result.levels and result.sequence.
/// collapse  has `Merge step()`, which does and returns the next merge, `FixedBits foliage_information()`, the present I(V,L), and
///           `std::uint64_t evaluations()`
/// progress  may be empty
template <class Collapse>
void collapse_down(Collapse& collapse, std::uint32_t leaf_count, const ProgressFunction& progress, CollapseResult& result) {
  const std::vector<std::uint32_t> levels = level_leaf_counts(leaf_count);
  const auto record_levels = [&](std::uint32_t live_count) {
    while (result.levels.size() < levels.size() && levels[result.levels.size()] == live_count)
      result.levels.push_back({live_count, to_bits(collapse.foliage_information())});
  };
  result.source = {leaf_count, to_bits(collapse.foliage_information())};
  record_levels(leaf_count);
  const std::uint32_t report_every = std::max(1u, leaf_count / 500);
  for (std::uint32_t live_count = leaf_count; live_count > 1;) {
    result.sequence.merges.push_back(collapse.step());
    record_levels(--live_count);
    if (progress && (live_count % report_every == 0 || live_count == 1))
      progress(static_cast<double>(leaf_count - live_count) / (leaf_count - 1));
  }
  result.sequence.evaluations = collapse.evaluations();
}

}  // namespace coppice::bake
