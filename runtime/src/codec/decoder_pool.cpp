#include "decoder_pool.h"

#include <utility>

#include "symbol_reader.h"

namespace coppice {

// Draco's vectors hold a number for every step of probability and two for every symbol, in each context; and the plain bits.
static_assert(DecoderPool::kSetBytes >= sizeof(DecoderPool::Set) + page_model::kContextCount * sizeof(std::uint32_t) * kProbabilityOne +
                                            page_model::kSymbolCount * sizeof(draco::rans_sym) + BitReader::kMaxBytes);

DecoderPool::DecoderPool() = default;
DecoderPool::~DecoderPool() = default;

DecoderPool::Lease::Lease(DecoderPool& pool) : pool_(pool) {
  {
    const std::lock_guard lock(pool.mutex_);
    set_ = std::move(pool.kept_);
  }
  if (!set_) set_ = std::make_unique<Set>();
}

DecoderPool::Lease::~Lease() {
  const std::lock_guard lock(pool_.mutex_);
  if (!pool_.kept_) pool_.kept_ = std::move(set_);
}

}  // namespace coppice
