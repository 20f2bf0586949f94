#pragma once

// Sorts instances by their places, so that blocks of consecutive slots hold neighbours: in steps, because a frame has no time for all of
// it.
//
// This is radix exchange on Morton codes. A run of slots is parted by the highest bit in which the codes of its instances differ: two
// instances on the wrong sides are exchanged until none is left. Then both parts are runs to be sorted. Short runs stay as they are. Slots
// may be empty, and between two steps instances may come, go and move; the next sort puts those in order.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "vectors.h"

namespace coppice::gpu {

/// A place, in whole metres along x, z and y. The order is that in which axes are split.
struct PlaceCode {
  static constexpr std::uint32_t kBits = 27;
  std::array<std::uint32_t, 3> along{};

  PlaceCode() = default;
  explicit PlaceCode(const dvec3& place_m) {
    constexpr double kOrigin_m = 1u << (kBits - 1);
    const double axes[3] = {place_m.x, place_m.z, place_m.y};
    for (std::size_t i = 0; i < 3; ++i) along[i] = static_cast<std::uint32_t>(std::clamp(axes[i] + kOrigin_m, 0.0, 2 * kOrigin_m - 1));
  }
  bool operator==(const PlaceCode&) const = default;
};

class PlaceSort {
 public:
  /// Begins to sort slots [0, end).
  void begin(std::uint32_t end) {
    count_ = 0;
    waiting_[count_++] = {.first = 0, .end = end};
    next_run();
  }
  [[nodiscard]] bool is_done() const { return !busy_; }

  /// Goes on. effort: looks at an instance; an exchange counts as kSwapEffort. Slots has
  ///   bool is_used(slot)
  ///   uint32_t after(slot), before(slot)   for an empty slot: the next one to look at, > slot; the end of those before it to look at, <=
  ///   slot PlaceCode code(slot)                 for a used one void swap(a, b)                      exchanges the instances of two used
  ///   slots
  template <class Slots>
  void run(Slots& slots, std::int32_t effort) {
    while (busy_) {
      for (; low_ < high_; --effort) {
        if (effort <= 0) return;
        if (step(slots)) effort -= kSwapEffort;
      }
      // There is room unless instances have moved far meanwhile, and then another sort follows.
      if (count_ + 2 <= kMaxRuns) {
        waiting_[count_++] = {low_, run_.end, upper_};
        waiting_[count_++] = {run_.first, low_, lower_};
      }
      next_run();
    }
  }
  static constexpr std::int32_t kSwapEffort = 8;

 private:
  /// Bits that some codes have, and bits that all have.
  struct Spread {
    std::array<std::uint32_t, 3> any{}, all{~0u, ~0u, ~0u};

    void add(const PlaceCode& code) {
      for (std::size_t i = 0; i < 3; ++i) {
        any[i] |= code.along[i];
        all[i] &= code.along[i];
      }
    }
    [[nodiscard]] std::uint32_t differing(std::size_t axis) const { return any[axis] & ~all[axis]; }
  };
  static constexpr std::uint32_t kEveryBit = (1u << PlaceCode::kBits) - 1;
  struct Run {
    std::uint32_t first = 0, end = 0;
    Spread of{{kEveryBit, kEveryBit, kEveryBit}, {}};
  };
  static constexpr std::uint32_t kShortRun = 16;
  static constexpr std::uint32_t kMaxRuns = 3 * PlaceCode::kBits + 2;  ///< a run has parts only below its own bit

  [[nodiscard]] bool is_upper(const PlaceCode& code) const { return (code.along[axis_] & bit_) != 0; }

  /// Looks at one end of what is left of the run. True: two instances were exchanged
  template <class Slots>
  bool step(Slots& slots) {
    if (!slots.is_used(low_)) {
      low_ = std::min(slots.after(low_), high_);
      return false;
    }
    const PlaceCode low = slots.code(low_);
    if (!is_upper(low)) {
      lower_.add(low);
      ++low_;
      return false;
    }
    if (!slots.is_used(high_ - 1)) {
      high_ = slots.before(high_ - 1);  // low_, which is used, or above
      return false;
    }
    const PlaceCode high = slots.code(--high_);
    upper_.add(is_upper(high) ? high : low);
    if (is_upper(high)) return false;
    slots.swap(low_++, high_);
    lower_.add(high);
    return true;
  }

  void next_run() {
    for (busy_ = false; count_ > 0 && !busy_;) {
      run_ = waiting_[--count_];
      if (run_.end - run_.first <= kShortRun) continue;
      axis_ = 0;
      for (std::size_t i = 1; i < 3; ++i)
        if (std::bit_width(run_.of.differing(i)) > std::bit_width(run_.of.differing(axis_))) axis_ = i;
      bit_ = std::bit_floor(run_.of.differing(axis_));
      busy_ = bit_ != 0;
    }
    low_ = run_.first;
    high_ = run_.end;
    lower_ = upper_ = {};
  }

  std::array<Run, kMaxRuns> waiting_{};  ///< [count_] a stack
  std::uint32_t count_ = 0;
  Run run_;               ///< the run that is being parted
  bool busy_ = false;     ///< there is one
  std::size_t axis_ = 0;  ///< by this bit along this axis
  std::uint32_t bit_ = 0;
  std::uint32_t low_ = 0, high_ = 0;  ///< slots [low_, high_) of it were not looked at
  Spread lower_, upper_;              ///< of the slots before and behind
};

}  // namespace coppice::gpu
