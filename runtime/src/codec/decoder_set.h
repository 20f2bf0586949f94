#pragma once

// One page's decoders. Draco stays inside: only decoder_pool.cpp and page_codec.cpp include this.

#include <array>
#include <cstddef>
#include <utility>

#include "decoder_pool.h"
#include "symbol_reader.h"

namespace coppice {

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
