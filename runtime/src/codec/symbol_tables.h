#pragma once

// Frequencies of a page's symbols (FORMAT.md, section 9), which Draco's entropy coder codes by.

#include <cstdint>
#include <span>

namespace coppice {

inline constexpr std::uint32_t kProbabilityBits = 10;
inline constexpr std::uint32_t kProbabilityOne = 1u << kProbabilityBits;

/// Weight of a symbol by the digit stored for it: 0 1 2 3 4 6 8 12 16 24 ... 192.
constexpr std::uint32_t symbol_weight(std::uint32_t digit) {
  if (digit < 4) return digit;
  return digit % 2 == 0 ? 1u << (digit / 2) : 3u << ((digit - 3) / 2);
}
inline constexpr std::uint32_t kWeightDigits = 16;

/// An extra share of the heaviest symbol, so that it can end a block. Draco's decoder recognises its first state only if it has not just
/// dropped a byte, as it does after rarer symbols.
inline constexpr std::uint32_t kEndShare = 4;

/// Divides kProbabilityOne by weight. Each of the n symbols that have a weight gets 1 plus floor(weight * (kProbabilityOne - kEndShare - n)
/// / sum of weights); the heaviest symbol, of several the first, also gets the remainder.
/// digits         [<= 256] below kWeightDigits, one of them above 0
/// probabilities  [digits.size()]
void share_out(std::span<const std::uint8_t> digits, std::span<std::uint32_t> probabilities);

/// The symbol that ends a context's block: the likeliest, of several the first.
std::uint32_t end_symbol(std::span<const std::uint32_t> probabilities);

constexpr std::uint32_t zigzag(std::int32_t value) {
  return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31);
}
constexpr std::int32_t unzigzag(std::uint32_t value) {
  return static_cast<std::int32_t>(value >> 1) ^ -static_cast<std::int32_t>(value & 1);
}

}  // namespace coppice
