#pragma once

// What the page encoder and decoder agree on (FORMAT.md, "PAGE"). A split becomes kSplitValues non-negative integers, small where the
// data is regular, spread over a few Draco attributes so that values of like size share one entropy coder.

#include <array>
#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "tree.h"

namespace coppice::page_layout {

/// Components of each attribute, in order: parent; slot set; slot order; cards; three coordinates of each new vertex.
/// Measured on five plants: one attribute a vertex beats one a coordinate by 1.7 to 2.6 B/leaf and one for all by 0.3 to 3.3 B/leaf.
inline constexpr std::array<std::uint8_t, 8> kAttributeComponents = {1, 1, 1, 2, 3, 3, 3, 3};
inline constexpr std::size_t kSplitValues = 17;
using SplitValues = std::array<std::uint32_t, kSplitValues>;

/// Signed to unsigned so that small stays small: 0 -1 1 -2 2 -> 0 1 2 3 4. Draco does the same to every value it stores.
constexpr std::uint32_t zigzag(std::int32_t value) {
  return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31);
}
constexpr std::int32_t unzigzag(std::uint32_t value) {
  return static_cast<std::int32_t>(value >> 1) ^ -static_cast<std::int32_t>(value & 1);
}

/// The eight corners of a pair of children, some of them known.
struct Slots {
  std::array<QuantisedPoint, 8> points{};
  std::array<bool, 8> known{};
  void set(std::size_t slot, const QuantisedPoint& point) {
    points[slot] = point;
    known[slot] = true;
  }
};

/// The parent's corners in their slots.
/// parent_slots  each < 8
inline Slots parent_corners(const QuantisedQuad& parent, const std::array<std::uint8_t, 4>& parent_slots) {
  Slots slots;
  for (std::size_t corner = 0; corner < 4; ++corner) slots.set(parent_slots[corner], parent[corner]);
  return slots;
}

/// Guess of an unknown corner from the known ones, at least one of which there is.
QuantisedPoint predict_corner(const Slots& slots, std::size_t slot);

/// Rank in 0..69 of the set of slots a parent fills, and in 0..23 of the order it fills them in.
struct SlotRank {
  std::uint32_t set, order;
};
SlotRank rank_of_slots(const std::array<std::uint8_t, 4>& parent_slots);
/// The reverse. set < 70, order < 24.
std::array<std::uint8_t, 4> slots_of_rank(SlotRank rank);

}  // namespace coppice::page_layout
