#pragma once

// The writing half of symbol_coder.h.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "symbol_coder.h"

namespace coppice::bake {

/// The digits whose weights are nearest to `counts`; 0 exactly where a count is 0. counts  one of them above 0
std::vector<std::uint8_t> weight_digits(std::span<const std::uint32_t> counts);

/// Bits that a symbol of each range takes; infinite for an empty one.
std::vector<double> symbol_costs(std::span<const SymbolRange> ranges);

/// The words that SymbolReader reads `ranges` from, one range a symbol, in its order. No range is empty (asserted).
std::vector<std::uint16_t> write_symbols(std::span<const SymbolRange> ranges);

/// Plain bits, lowest first.
class BitWriter {
 public:
  /// bits  < 2^count
  void add(std::uint32_t bits, std::uint32_t count);
  /// With zeros up to a whole byte, and to BitReader::kLeastBytes.
  [[nodiscard]] std::vector<std::uint8_t> finish() const;

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint32_t filled_ = 0;  ///< bits of the last byte, 1..8; 0 while there is none
};

}  // namespace coppice::bake
