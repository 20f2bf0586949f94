#pragma once

// Entropy coding of a page (FORMAT.md, section 9). Symbols go through range asymmetric numeral systems (rANS, J. Duda 2013): a state of 32
// bits, probabilities in 1024ths that do not change within the page, renormalised by 16 bits. Two states take turns, so that one
// multiplication need not wait for the one before. What is no symbol is stored as plain bits.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace coppice {

inline constexpr std::uint32_t kProbabilityBits = 10;
inline constexpr std::uint32_t kProbabilityOne = 1u << kProbabilityBits;
inline constexpr std::uint32_t kLowestState = 1u << 16;

/// A symbol's share of [0, kProbabilityOne).
struct SymbolRange {
  std::uint16_t start = 0, size = 0;
};

/// Which symbol each point of [0, kProbabilityOne) belongs to.
struct SymbolTable {
  std::array<std::uint8_t, kProbabilityOne> symbol_at;
};

/// Weight of a symbol by the digit stored for it: 0 1 2 3 4 6 8 12 16 24 ... 192.
constexpr std::uint32_t symbol_weight(std::uint32_t digit) {
  if (digit < 4) return digit;
  return digit % 2 == 0 ? 1u << (digit / 2) : 3u << ((digit - 3) / 2);
}
inline constexpr std::uint32_t kWeightDigits = 16;

/// Ranges that share kProbabilityOne out by weight: 1 for each of the n symbols that have one, plus floor(weight * (kProbabilityOne - n) /
/// sum of weights); the heaviest symbol, of several the first, takes what is left over.
/// digits  [<= 256] below kWeightDigits, one of them above 0
/// ranges  [digits.size()]
void share_out(std::span<const std::uint8_t> digits, std::span<SymbolRange> ranges);

/// The inverse of `ranges`, which must cover [0, kProbabilityOne) in order.
void fill_symbol_table(std::span<const SymbolRange> ranges, SymbolTable& table);

constexpr std::uint32_t zigzag(std::int32_t value) {
  return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31);
}
constexpr std::int32_t unzigzag(std::uint32_t value) {
  return static_cast<std::int32_t>(value >> 1) ^ -static_cast<std::int32_t>(value & 1);
}

/// Reads symbols. Damaged input gives symbols of the tables, never a read outside `words`; finished() tells.
class SymbolReader {
 public:
  /// words  little-endian u16, the first four the two states; at least two readable bytes must follow them
  SymbolReader(const std::uint8_t* words, std::size_t word_count) : words_(words), word_count_(word_count) {
    now_ = next_word();
    now_ |= next_word() << 16;
    then_ = next_word();
    then_ |= next_word() << 16;
  }

  std::uint32_t next(const SymbolTable& table, const SymbolRange* ranges) {
    const std::uint32_t at = now_ & (kProbabilityOne - 1);
    const std::uint32_t symbol = table.symbol_at[at];
    const SymbolRange range = ranges[symbol];
    std::uint32_t state = range.size * (now_ >> kProbabilityBits) + at - range.start;
    const bool low = state < kLowestState;
    const std::uint32_t longer = state << 16 | word_at(position_);
    position_ += low && position_ < word_count_ ? 1u : 0u;
    state = low ? longer : state;
    now_ = then_;
    then_ = state;
    return symbol;
  }

  /// All words are read and the states are what the writer started from.
  [[nodiscard]] bool finished() const { return position_ == word_count_ && now_ == kLowestState && then_ == kLowestState; }

 private:
  [[nodiscard]] std::uint32_t word_at(std::size_t position) const {
    std::uint16_t word;
    std::memcpy(&word, words_ + 2 * position, sizeof word);
    return word;
  }
  std::uint32_t next_word() { return word_at(position_++); }

  const std::uint8_t* words_;
  std::size_t word_count_;
  std::size_t position_ = 0;
  std::uint32_t now_, then_;
};

/// Reads plain bits, lowest first. Past the end it gives some of the bits again; used() tells.
class BitReader {
 public:
  static constexpr std::size_t kLeastBytes = 8;

  /// bytes  at least kLeastBytes
  explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes.data()), last_(bytes.size() - kLeastBytes) {}

  /// count  <= 56
  std::uint64_t next(std::uint32_t count) {
    const std::size_t byte = position_ / 8 < last_ ? position_ / 8 : last_;
    std::uint64_t bits;
    std::memcpy(&bits, bytes_ + byte, sizeof bits);
    bits >>= (position_ - 8 * byte) & 63;
    position_ += count;
    return bits & ((std::uint64_t{1} << count) - 1);
  }

  [[nodiscard]] std::size_t used() const { return position_; }

 private:
  const std::uint8_t* bytes_;
  std::size_t last_;
  std::size_t position_ = 0;
};

}  // namespace coppice
