#pragma once

// The mutual information of foliage and viewpoints: the paper's equations (7) and (8), on integer areas.
//
// An outcome is a leaf, or the background if it counts. One function computes each outcome's share from its integer areas, in a fixed
// order, and rounds it to a multiple of 2^-40 bits. Sums of such integers are exact in any order. So adding up what a collapse changed
// gives the same number as adding up everything, and a comparison never depends on how its numbers came about.

#include <cstdint>
#include <span>
#include <vector>

namespace coppice::bake {

/// Information in units of 2^-40 bits.
using FixedBits = std::int64_t;
inline constexpr double kFixedPerBit = 1099511627776.0;  ///< 2^40

[[nodiscard]] inline double to_bits(FixedBits fixed) {
  return static_cast<double>(fixed) / kFixedPerBit;
}

/// a_t(v) of every view, prepared for outcome_information.
struct ViewTotals {
  std::vector<double> reciprocal;  ///< [view_count] 1 / a_t(v), 0 for an empty view
  std::vector<double> log2_total;  ///< [view_count]
};

/// totals_px  [view_count] the whole image, or the visible foliage; that may be 0, and then every p(l|v) of the view is 0
ViewTotals view_totals(std::span<const std::uint32_t> totals_px);
/// background_px  [view_count] If the background counts, a_t is the whole image, else the rest of it.
ViewTotals view_totals(std::span<const std::uint32_t> background_px, std::uint32_t pixels_per_view, bool count_background);

/// I(V,l), equation (8): (1/N_v) sum_v p(l|v) log2(p(l|v) / p(l)) with p(l|v) = a_l(v) / a_t(v) and p(l) = (1/N_v) sum_v p(l|v).
/// areas_px  [view_count] a_l(v) of one outcome, <= a_t(v)
/// returns   >= 0; 0 for an outcome that no view sees or that has the same share of every view. Views in index order.
FixedBits outcome_information(std::span<const std::uint32_t> areas_px, const ViewTotals& totals);

}  // namespace coppice::bake
