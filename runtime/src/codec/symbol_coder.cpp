#include "symbol_coder.h"

#include <algorithm>

#include "check.h"

namespace coppice {

void share_out(std::span<const std::uint8_t> digits, std::span<SymbolRange> ranges) {
  std::uint32_t sum = 0, used = 0;
  for (std::uint8_t digit : digits) {
    sum += symbol_weight(digit);
    used += digit > 0 ? 1u : 0u;
  }
  COPPICE_ASSERT(sum > 0);
  std::size_t heaviest = 0;
  std::uint32_t given = 0;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const std::uint32_t size = digits[i] == 0 ? 0 : 1 + symbol_weight(digits[i]) * (kProbabilityOne - used) / sum;
    ranges[i].size = static_cast<std::uint16_t>(size);
    given += size;
    if (digits[i] > digits[heaviest]) heaviest = i;
  }
  ranges[heaviest].size = static_cast<std::uint16_t>(ranges[heaviest].size + kProbabilityOne - given);
  std::uint32_t start = 0;
  for (SymbolRange& range : ranges.first(digits.size())) {
    range.start = static_cast<std::uint16_t>(start);
    start += range.size;
  }
}

void fill_symbol_table(std::span<const SymbolRange> ranges, SymbolTable& table) {
  for (std::size_t symbol = 0; symbol < ranges.size(); ++symbol)
    std::fill_n(table.symbol_at.begin() + ranges[symbol].start, ranges[symbol].size, static_cast<std::uint8_t>(symbol));
}

}  // namespace coppice
