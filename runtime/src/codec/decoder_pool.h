#pragma once

#include <cstddef>
#include <memory>
#include <mutex>

#include "coppice/format.h"
#include "page_model.h"

namespace coppice {

/// Draco's decoders of pages, which it allocates with new: a set for each page that is decoded at the same time. One set is kept between
/// pages, others are made when it is taken and go with their page; so pages decoded one after another allocate nothing. Any thread.
class DecoderPool {
 public:
  struct Set;

  DecoderPool();
  ~DecoderPool();
  DecoderPool(const DecoderPool&) = delete;
  DecoderPool& operator=(const DecoderPool&) = delete;

  /// What a set takes at most, whatever the page: tables with room for any alphabet, room for a page's plain bits, and what holds these.
  static constexpr std::size_t kSetBytes = 152u << 10;

  /// Has a set for a page.
  class Lease {
   public:
    /// Throws std::bad_alloc
    explicit Lease(DecoderPool& pool);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Set& operator*() const { return *set_; }

   private:
    DecoderPool& pool_;
    std::unique_ptr<Set> set_;
  };

 private:
  std::mutex mutex_;
  std::unique_ptr<Set> kept_;  ///< null while it is taken, and before the first page
};

}  // namespace coppice
