#pragma once

#include <cstddef>
#include <memory>
#include <mutex>

#include "coppice/format.h"
#include "page_model.h"

namespace coppice {

/// Holds Draco's page decoders, which Draco allocates with new: one set for each page that is decoded at the same time. One set is kept
/// between pages. Others are made on demand and freed with their page, so pages decoded one after another allocate nothing. Any thread.
class DecoderPool {
 public:
  struct Set;

  DecoderPool();
  ~DecoderPool();
  DecoderPool(const DecoderPool&) = delete;
  DecoderPool& operator=(const DecoderPool&) = delete;

  /// Maximum memory of a set for any page: tables for any alphabet, a page's plain bits, and the objects that hold these.
  static constexpr std::size_t kSetBytes = 204u << 10;

  /// Reserves a set for one page.
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
  std::unique_ptr<Set> kept_;  ///< null while it is in use, and before the first page
};

}  // namespace coppice
