#pragma once

// One memory budget that all modules reserve from, so that none keeps sums of another's.

#include <algorithm>
#include <cstdint>

namespace coppice {

/// Counts bytes. One part of the budget is reserved: in use, or promised to work in progress. The rest is free. `refused` is the largest
/// request that did not fit in the last frames: whoever can free memory does, and nobody reserves bytes that would leave less than that
/// free.
/// Thread: externally serialised.
class Ledger {
 public:
  static constexpr std::uint64_t kUnlimited = ~std::uint64_t{0};
  /// Number of frames for which a refusal is remembered.
  static constexpr std::uint64_t kRefusalFrames = 60;

  explicit Ledger(std::uint64_t budget_bytes = kUnlimited) : budget_(budget_bytes) {}

  /// Reserved bytes stay reserved, even beyond the budget.
  void set_budget(std::uint64_t bytes) { budget_ = bytes; }
  [[nodiscard]] std::uint64_t budget() const { return budget_; }
  [[nodiscard]] std::uint64_t reserved() const { return reserved_; }
  [[nodiscard]] std::uint64_t max_reserved() const { return max_reserved_; }
  [[nodiscard]] std::uint64_t free() const { return budget_ - std::min(budget_, reserved_); }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

  /// True if this many bytes are free. Otherwise the request is noted as a refusal.
  [[nodiscard]] bool fits(std::uint64_t bytes) {
    const bool fits = bytes <= free();
    if (!fits) {
      refused_ = std::max(refused_, bytes);
      refusal_frame_ = frame_;
    } else if (bytes >= refused_) {
      refused_ = 0;
    }
    return fits;
  }
  /// Reserves bytes. Call it after fits(), or for memory that exists already; the sum may exceed the budget.
  void reserve(std::uint64_t bytes) {
    reserved_ += bytes;
    max_reserved_ = std::max(max_reserved_, reserved_);
  }
  void release(std::uint64_t bytes) { reserved_ -= bytes; }

  void begin_frame(std::uint64_t frame_number) {
    frame_ = frame_number;
    if (frame_ > refusal_frame_ + kRefusalFrames) refused_ = 0;
  }

 private:
  std::uint64_t budget_, reserved_ = 0, max_reserved_ = 0;
  std::uint64_t refused_ = 0, frame_ = 0, refusal_frame_ = 0;
};

}  // namespace coppice
