#include "symbol_writer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "check.h"

namespace coppice::bake {

std::vector<std::uint8_t> weight_digits(std::span<const std::uint32_t> counts) {
  const double most = *std::ranges::max_element(counts);
  std::vector<std::uint8_t> digits;
  for (std::uint32_t count : counts) {
    std::uint8_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint8_t digit = 1; count > 0 && digit < kWeightDigits; ++digit) {
      const double off = std::abs(std::log2(count / most * symbol_weight(kWeightDigits - 1) / symbol_weight(digit)));
      if (off >= least) continue;
      least = off;
      nearest = digit;
    }
    digits.push_back(nearest);
  }
  return digits;
}

std::vector<double> symbol_costs(std::span<const SymbolRange> ranges) {
  std::vector<double> costs;
  for (const SymbolRange& range : ranges)
    costs.push_back(range.size == 0 ? std::numeric_limits<double>::infinity() : std::log2(double{kProbabilityOne} / range.size));
  return costs;
}

std::vector<std::uint16_t> write_symbols(std::span<const SymbolRange> ranges) {
  std::array<std::uint32_t, 2> states = {kLowestState, kLowestState};
  std::vector<std::uint16_t> words;
  for (std::size_t i = ranges.size(); i-- > 0;) {
    const SymbolRange& range = ranges[i];
    COPPICE_ASSERT(range.size > 0);
    std::uint32_t& state = states[i % 2];
    if (state >= std::uint64_t{range.size} << (32 - kProbabilityBits)) {
      words.push_back(static_cast<std::uint16_t>(state & 0xffffu));
      state >>= 16;
    }
    state = (state / range.size << kProbabilityBits) + state % range.size + range.start;
  }
  for (std::size_t i = 2; i-- > 0;) {
    words.push_back(static_cast<std::uint16_t>(states[i] >> 16));
    words.push_back(static_cast<std::uint16_t>(states[i] & 0xffffu));
  }
  std::ranges::reverse(words);
  return words;
}

void BitWriter::add(std::uint32_t bits, std::uint32_t count) {
  for (; count > 0; --count, bits >>= 1) {
    if (filled_ % 8 == 0) {
      bytes_.push_back(0);
      filled_ = 0;
    }
    bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | (bits & 1) << filled_);
    ++filled_;
  }
}

std::vector<std::uint8_t> BitWriter::finish() const {
  std::vector<std::uint8_t> bytes = bytes_;
  bytes.resize(std::max(bytes.size(), BitReader::kLeastBytes));
  return bytes;
}

}  // namespace coppice::bake
