#include "mutual_information.h"

#include <cmath>

namespace coppice::bake {
namespace {

/// [value] log2 of small integers, since nearly every area is small; 0 for 0, so that 0 log 0 = 0.
const std::vector<double>& log2_table() {
  static const std::vector<double> table = [] {
    std::vector<double> values(65537, 0.0);
    for (std::size_t i = 1; i < values.size(); ++i) values[i] = std::log2(static_cast<double>(i));
    return values;
  }();
  return table;
}

double log2_of(std::uint32_t value, const std::vector<double>& table) {
  return value < table.size() ? table[value] : std::log2(static_cast<double>(value));
}

}  // namespace

ViewTotals view_totals(std::span<const std::uint32_t> totals_px) {
  ViewTotals totals;
  for (const std::uint32_t total_px : totals_px) {
    totals.reciprocal.push_back(total_px == 0 ? 0.0 : 1.0 / total_px);
    totals.log2_total.push_back(log2_of(total_px, log2_table()));
  }
  return totals;
}

ViewTotals view_totals(std::span<const std::uint32_t> background_px, std::uint32_t pixels_per_view, bool count_background) {
  std::vector<std::uint32_t> totals_px;
  for (const std::uint32_t px : background_px) totals_px.push_back(pixels_per_view - (count_background ? 0 : px));
  return view_totals(totals_px);
}

FixedBits outcome_information(std::span<const std::uint32_t> areas_px, const ViewTotals& totals) {
  const std::vector<double>& table = log2_table();
  double share_sum = 0.0, weighted_logs = 0.0;
  for (std::size_t v = 0; v < areas_px.size(); ++v) {
    const double share = areas_px[v] * totals.reciprocal[v];
    share_sum += share;
    weighted_logs += share * (log2_of(areas_px[v], table) - totals.log2_total[v]);
  }
  if (share_sum == 0.0) return 0;
  const auto view_count = static_cast<double>(areas_px.size());
  const double bits = (weighted_logs - share_sum * std::log2(share_sum / view_count)) / view_count;
  return static_cast<FixedBits>(std::floor(bits * kFixedPerBit + 0.5));
}

}  // namespace coppice::bake
