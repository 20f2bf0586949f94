#include "symbol_tables.h"

#include <algorithm>
#include <cstddef>

#include "check.h"

namespace coppice {

void share_out(std::span<const std::uint8_t> digits, std::span<std::uint32_t> probabilities) {
  std::uint32_t sum = 0, used = 0;
  for (std::uint8_t digit : digits) {
    sum += symbol_weight(digit);
    used += digit > 0 ? 1u : 0u;
  }
  COPPICE_ASSERT(sum > 0);
  std::size_t heaviest = 0;
  std::uint32_t given = 0;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    probabilities[i] = digits[i] == 0 ? 0 : 1 + symbol_weight(digits[i]) * (kProbabilityOne - kEndShare - used) / sum;
    given += probabilities[i];
    if (digits[i] > digits[heaviest]) heaviest = i;
  }
  probabilities[heaviest] += kProbabilityOne - given;
}

std::uint32_t end_symbol(std::span<const std::uint32_t> probabilities) {
  return static_cast<std::uint32_t>(std::ranges::max_element(probabilities) - probabilities.begin());
}

}  // namespace coppice
