#pragma once

// What a page is read from: Draco's rANS decoder, one a context, and its decoder of plain bits. Draco keeps tables and bits in vectors, so
// readers are made once with room for any page and used for one page after another. Draco trusts lengths; they are checked here.
//
// Only decoder_set.h includes this: Draco stays inside.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <draco/compression/bit_coders/direct_bit_decoder.h>
#include <draco/compression/entropy/ans.h>
#include <draco/core/decoder_buffer.h>

#include "page_model.h"
#include "symbol_tables.h"

namespace coppice {

/// Symbols of one context. Damaged input gives symbols of the table and no read outside the block; finished() tells.
class SymbolReader {
 public:
  /// most  symbols of the alphabet. Allocates whatever tables will need
  explicit SymbolReader(std::size_t most) {
    std::vector<std::uint32_t> probabilities(most);
    probabilities.back() = kProbabilityOne;
    draco_.rans_build_look_up_table(probabilities.data(), static_cast<std::uint32_t>(most));
  }

  /// digits  as for share_out
  void set_table(std::span<const std::uint8_t> digits) {
    std::array<std::uint32_t, 256> probabilities;
    share_out(digits, probabilities);
    draco_.rans_build_look_up_table(probabilities.data(), static_cast<std::uint32_t>(digits.size()));
    end_ = end_symbol(std::span(probabilities).first(digits.size()));
    only_one_ = probabilities[end_] == kProbabilityOne;
  }
  /// A context of one symbol needs no bytes to say which.
  [[nodiscard]] bool only_one() const { return only_one_; }

  /// block  of Draco, which must outlive the reader's use; empty where no symbol follows. False if it is none
  bool start(std::span<const std::uint8_t> block) {
    static constexpr std::array<std::uint8_t, 1> kNone = {0};  // the state that a writer starts from
    empty_ = block.empty();
    if (empty_) block = kNone;
    constexpr unsigned kLongestEnd =
        3;  // the last byte's highest bits say how many bytes the state takes, less one; Draco does not compare
    const unsigned end_bytes = (block.back() >> 6) + 1u;
    if (end_bytes > kLongestEnd || end_bytes > block.size()) return false;
    return draco_.read_init(block.data(), static_cast<int>(block.size())) == 0;
  }

  std::uint32_t next() { return static_cast<std::uint32_t>(draco_.rans_read()); }

  /// The end's symbol comes next, all bytes are read and the state is what the writer started from. Nothing may be read after it.
  [[nodiscard]] bool finished() {
    if (!empty_ && next() != end_) return false;
    if (draco_.read_end() == 0) return false;
    if (only_one_ || empty_) return true;
    next();  // takes the state below what it starts from, where Draco tells whether bytes are left
    return draco_.reader_has_error() != 0;
  }

 private:
  draco::RAnsDecoder<int{kProbabilityBits}> draco_;
  std::uint32_t end_ = 0;
  bool only_one_ = false, empty_ = false;
};

/// Plain bits, of each number the highest first. Past the end they are 0; finished() tells.
class BitReader {
 public:
  static constexpr std::size_t kLengthBytes = 4, kWordBytes = 4;  ///< as Draco stores them
  static constexpr std::size_t kMostBytes =
      kLengthBytes + kWordBytes * (COPPICE_PAGE_SPLITS * page_model::kMostPlainBits / (8 * kWordBytes) + 1);

  /// Allocates whatever a page will need.
  BitReader() {
    std::array<std::uint8_t, kMostBytes> longest{};
    for (std::size_t i = 0; i < kLengthBytes; ++i) longest[i] = static_cast<std::uint8_t>((kMostBytes - kLengthBytes) >> (8 * i));
    start(longest);
  }

  /// bytes  at most kMostBytes. False if they are not Draco's, to the last one
  bool start(std::span<const std::uint8_t> bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    used_ = 0;
    ended_ = false;
    if (!draco_.StartDecoding(&buffer) || buffer.remaining_size() != 0) return false;
    bit_count_ = 8 * (bytes.size() - kLengthBytes);
    return true;
  }

  /// count  1 to 32
  std::uint32_t next(std::uint32_t count) {
    std::uint32_t value = 0;
    ended_ = !draco_.DecodeLeastSignificantBits32(static_cast<int>(count), &value) || ended_;
    used_ += count;
    return value;
  }

  /// What is left fills the last word with zeros. Nothing may be read after it.
  [[nodiscard]] bool finished() {
    constexpr std::size_t kWordBits = 8 * kWordBytes;
    if (ended_ || used_ / kWordBits + 1 != bit_count_ / kWordBits) return false;
    return next(static_cast<std::uint32_t>(bit_count_ - used_)) == 0;
  }

 private:
  draco::DirectBitDecoder draco_;
  std::size_t bit_count_ = 0, used_ = 0;
  bool ended_ = false;
};

}  // namespace coppice
