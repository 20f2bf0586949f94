#include "mutual_information.h"

#include <cmath>

namespace coppice::bake {
namespace {

/// A table of log2 of small integers: nearly every area is small.
class Log2Table {
 public:
  Log2Table() : values_(kSize, 0.0) {
    for (std::uint32_t i = 1; i < kSize; ++i) values_[i] = std::log2(static_cast<double>(i));
  }
  /// Returns 0 for 0, so that 0 log 0 = 0.
  [[nodiscard]] double operator()(std::uint32_t value) const {
    return value < kSize ? values_[value] : std::log2(static_cast<double>(value));
  }

 private:
  static constexpr std::uint32_t kSize = 65537;
  std::vector<double> values_;
};

const Log2Table& log2_table() {
  static const Log2Table table;
  return table;
}

}  // namespace

void ViewTotals::set(std::uint32_t view, std::uint32_t total_px) {
  reciprocal[view] = total_px == 0 ? 0.0 : 1.0 / total_px;
  log2_total[view] = log2_table()(total_px);
}

FixedBits outcome_information(std::span<const std::uint32_t> areas_px, const ViewTotals& totals) {
  const Log2Table& log2_of = log2_table();
  double share_sum = 0.0, weighted_logs = 0.0;
  for (std::size_t v = 0; v < areas_px.size(); ++v) {
    const double share = areas_px[v] * totals.reciprocal[v];
    share_sum += share;
    weighted_logs += share * (log2_of(areas_px[v]) - totals.log2_total[v]);
  }
  if (share_sum == 0.0) return 0;
  const auto view_count = static_cast<double>(areas_px.size());
  const double bits = (weighted_logs - share_sum * std::log2(share_sum / view_count)) / view_count;
  return static_cast<FixedBits>(std::floor(bits * kFixedPerBit + 0.5));
}

}  // namespace coppice::bake
