#pragma once

// The loop that all collapses share.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "collapse.h"
#include "mutual_information.h"
#include "progress.h"

namespace coppice::bake {

/// Steps a collapse down to one leaf. Fills result.source, result.levels and result.sequence.merges.
/// collapse  has `Merge step()`, which does and returns the next merge, and `FixedBits foliage_information()`, the present I(V,L)
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
}

}  // namespace coppice::bake
