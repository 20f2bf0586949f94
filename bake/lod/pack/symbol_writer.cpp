#include "symbol_writer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <draco/compression/bit_coders/direct_bit_encoder.h>
#include <draco/compression/entropy/ans.h>

#include "check.h"

namespace coppice::bake {

std::vector<std::uint8_t> weight_digits(std::span<const std::uint32_t> counts) {
  const double largest = *std::ranges::max_element(counts);
  std::vector<std::uint8_t> digits;
  for (std::uint32_t count : counts) {
    std::uint8_t nearest = 0;
    double smallest = std::numeric_limits<double>::infinity();
    for (std::uint8_t digit = 1; count > 0 && digit < kWeightDigits; ++digit) {
      const double off = std::abs(std::log2(count / largest * symbol_weight(kWeightDigits - 1) / symbol_weight(digit)));
      if (off >= smallest) continue;
      smallest = off;
      nearest = digit;
    }
    digits.push_back(nearest);
  }
  return digits;
}

std::vector<double> symbol_costs(std::span<const std::uint32_t> probabilities) {
  std::vector<double> costs;
  for (std::uint32_t probability : probabilities)
    costs.push_back(probability == 0 ? std::numeric_limits<double>::infinity() : std::log2(double{kProbabilityOne} / probability));
  return costs;
}

std::vector<std::uint8_t> write_symbols(std::span<const std::uint32_t> probabilities, std::span<const std::uint8_t> symbols) {
  if (symbols.empty() || std::ranges::count(probabilities, kProbabilityOne) > 0) return {};
  std::vector<draco::rans_sym> ranges;
  std::uint32_t start = 0;
  for (std::uint32_t probability : probabilities) {
    ranges.push_back({probability, start});
    start += probability;
  }
  COPPICE_ASSERT(start == kProbabilityOne);
  constexpr std::size_t kStateBytes = 4, kMaxSymbolBytes = 2;  // at most kProbabilityBits
  std::vector<std::uint8_t> block(kStateBytes + kMaxSymbolBytes * (symbols.size() + 1));
  draco::RAnsEncoder<int{kProbabilityBits}> encoder;
  encoder.write_init(block.data());
  encoder.rans_write(&ranges[end_symbol(probabilities)]);
  for (std::size_t i = symbols.size(); i-- > 0;) {
    const std::uint8_t symbol = symbols[i];
    COPPICE_ASSERT(symbol < ranges.size() && ranges[symbol].prob > 0);
    encoder.rans_write(&ranges[symbol]);
  }
  block.resize(static_cast<std::size_t>(encoder.write_end()));
  return block;
}

std::vector<std::uint8_t> write_bits(std::span<const PlainBits> numbers) {
  draco::DirectBitEncoder encoder;
  encoder.StartEncoding();
  for (const PlainBits& number : numbers) encoder.EncodeLeastSignificantBits32(static_cast<int>(number.count), number.bits);
  draco::EncoderBuffer buffer;
  encoder.EndEncoding(&buffer);
  const std::vector<char>& bytes = *buffer.buffer();
  return {bytes.begin(), bytes.end()};
}

}  // namespace coppice::bake
