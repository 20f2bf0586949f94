#pragma once

// How a split is stored in a page of version 1 (FORMAT.md, section 14). A split becomes kSplitValues non-negative integers, small where the
// data is regular, spread over a few Draco attributes so that values of like size share one entropy coder.

#include <array>
#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "tree.h"

namespace coppice::page_draco_layout {

/// Components of each attribute, in order: parent; slot set; slot order; cards; three coordinates of each new vertex.
/// Measured on five plants: one attribute a vertex beats one a coordinate by 1.7 to 2.6 B/leaf and one for all by 0.3 to 3.3 B/leaf.
inline constexpr std::array<std::uint8_t, 8> kAttributeComponents = {1, 1, 1, 2, 3, 3, 3, 3};
inline constexpr std::size_t kSplitValues = 17;
using SplitValues = std::array<std::uint32_t, kSplitValues>;

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

/// The slots a parent fills, from the rank in 0..69 of their set and the rank in 0..23 of the order it fills them in.
std::array<std::uint8_t, 4> slots_of_rank(std::uint32_t set, std::uint32_t order);

}  // namespace coppice::page_draco_layout
