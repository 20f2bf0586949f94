#pragma once

// The writing half of symbol_reader.h: Draco's rANS and bit encoders.

#include <cstdint>
#include <span>
#include <vector>

#include "symbol_tables.h"

namespace coppice::bake {

/// The digits with weights nearest to `counts`; 0 exactly if a count is 0. counts  at least one is above 0
std::vector<std::uint8_t> weight_digits(std::span<const std::uint32_t> counts);

/// Bits that each symbol takes at its probability; infinite for 0.
std::vector<double> symbol_costs(std::span<const std::uint32_t> probabilities);

/// Writes the block from which SymbolReader reads `symbols`; empty without symbols, or if there is only one to choose. All symbols have a
/// probability above 0 (asserted).
std::vector<std::uint8_t> write_symbols(std::span<const std::uint32_t> probabilities, std::span<const std::uint8_t> symbols);

struct PlainBits {
  std::uint32_t bits = 0;
  std::uint32_t count = 0;  ///< 1 to 32
};
/// Writes the bytes from which BitReader reads these numbers.
std::vector<std::uint8_t> write_bits(std::span<const PlainBits> numbers);

}  // namespace coppice::bake
