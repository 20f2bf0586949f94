#pragma once

// Reads the parts of a page: Draco's rANS decoder, one for each context, and its decoder of plain bits. Draco keeps tables and bits in
// vectors, so a reader is made once with space for any page and used for one page after another. Draco trusts lengths, so they are checked
// here.
//
// Draco stays inside: only decoder_pool.cpp and page_codec.cpp include this.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <draco/compression/bit_coders/direct_bit_decoder.h>
#include <draco/compression/entropy/ans.h>
#include <draco/core/decoder_buffer.h>

#include "decoder_pool.h"
#include "symbol_tables.h"

namespace coppice {

/// Reads symbols of one context. Damaged input gives symbols of the table and never a read outside the block; finished() finds it.
class SymbolReader {
 public:
  /// maximum  number of symbols in the alphabet. Allocates all memory for its tables
  explicit SymbolReader(std::size_t maximum) {
    std::vector<std::uint32_t> probabilities(maximum);
    probabilities.back() = kProbabilityOne;
    draco_.rans_build_look_up_table(probabilities.data(), static_cast<std::uint32_t>(maximum));
  }

  /// digits  as for share_out
  void set_table(std::span<const std::uint8_t> digits) {
    std::array<std::uint32_t, 256> probabilities;
    share_out(digits, probabilities);
    draco_.rans_build_look_up_table(probabilities.data(), static_cast<std::uint32_t>(digits.size()));
    end_ = end_symbol(std::span(probabilities).first(digits.size()));
    only_one_ = probabilities[end_] == kProbabilityOne;
  }
  /// True if the context has a single symbol, which needs no bytes.
  [[nodiscard]] bool only_one() const { return only_one_; }

  /// Starts to read a block; false if it is not a valid one. block  Draco's, outlives the reading; empty if no symbol follows
  bool start(std::span<const std::uint8_t> block) {
    static constexpr std::array<std::uint8_t, 1> kNone = {0};  // the state that a writer starts from
    empty_ = block.empty();
    if (empty_) block = kNone;
    constexpr unsigned kLongestEnd =
        3;  // the highest bits of the last byte give the number of bytes of the state, minus one; Draco does not compare them
    const unsigned end_bytes = (block.back() >> 6) + 1u;
    if (end_bytes > kLongestEnd || end_bytes > block.size()) return false;
    return draco_.read_init(block.data(), static_cast<int>(block.size())) == 0;
  }

  std::uint32_t next() { return static_cast<std::uint32_t>(draco_.rans_read()); }

  /// True if the end symbol comes next, all bytes are read and the state is the writer's first. Nothing may be read after it.
  [[nodiscard]] bool finished() {
    if (!empty_ && next() != end_) return false;
    if (draco_.read_end() == 0) return false;
    if (only_one_ || empty_) return true;
    next();  // brings the state below its first value, where Draco tells whether bytes are left
    return draco_.reader_has_error() != 0;
  }

 private:
  draco::RAnsDecoder<int{kProbabilityBits}> draco_;
  std::uint32_t end_ = 0;
  bool only_one_ = false, empty_ = false;
};

/// Reads plain bits, the highest bit of each number first. Bits past the end are 0; finished() finds that.
class BitReader {
 public:
  static constexpr std::size_t kLengthBytes = 4, kWordBytes = 4;  ///< as Draco stores them
  static constexpr std::size_t kMaxBytes =
      kLengthBytes + kWordBytes * (COPPICE_PAGE_SPLITS * page_model::kMaxPlainBits / (8 * kWordBytes) + 1);

  /// Allocates memory for any page.
  BitReader() {
    std::array<std::uint8_t, kMaxBytes> longest{};
    for (std::size_t i = 0; i < kLengthBytes; ++i) longest[i] = static_cast<std::uint8_t>((kMaxBytes - kLengthBytes) >> (8 * i));
    start(longest);
  }

  /// Starts to read; false if the bytes are not entirely Draco's. bytes  at most kMaxBytes
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

  /// True if the rest of the last word is zeros. Nothing may be read after it.
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

/// One page's decoders.
struct DecoderPool::Set {
  std::array<SymbolReader, page_model::kContextCount> symbols = readers(std::make_index_sequence<page_model::kContextCount>());
  std::array<std::size_t, page_model::kContextCount> usual{};  ///< number of symbols of a reader's default table; 0 if it has another table
  BitReader bits;

 private:
  template <std::size_t... kContext>
  static std::array<SymbolReader, page_model::kContextCount> readers(std::index_sequence<kContext...>) {
    return {SymbolReader(page_model::kAlphabet[kContext])...};
  }
};

}  // namespace coppice
