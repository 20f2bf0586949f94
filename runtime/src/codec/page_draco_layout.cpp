#include "page_draco_layout.h"

#include <algorithm>

namespace coppice::page_draco_layout {

namespace {

/// binomial(n, k) for n <= 7, k <= 4.
constexpr std::uint32_t binomial(std::uint32_t n, std::uint32_t k) {
  std::uint32_t value = 1;
  for (std::uint32_t i = 0; i < k; ++i) value = value * (n - i) / (i + 1);
  return k > n ? 0 : value;
}

std::uint16_t clamp_coordinate(int value) {
  return static_cast<std::uint16_t>(std::clamp(value, 0, static_cast<int>(COPPICE_QUANTISED_MAX)));
}

std::array<int, 3> known_centre(const Slots& slots) {
  std::array<int, 3> sum{};
  int count = 0;
  for (std::size_t slot = 0; slot < 8; ++slot) {
    if (!slots.known[slot]) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += slots.points[slot][axis];
    ++count;
  }
  return {sum[0] / count, sum[1] / count, sum[2] / count};
}

}  // namespace

QuantisedPoint predict_corner(const Slots& slots, std::size_t slot) {
  const std::size_t child = slot & 4, next = child | ((slot + 1) & 3), across = child | ((slot + 2) & 3), before = child | ((slot + 3) & 3);
  const std::array<QuantisedPoint, 8>& points = slots.points;
  if (slots.known[next] && slots.known[before]) {
    // Leaf quads are near parallelograms; without the corner across, the middle of the diagonal.
    QuantisedPoint guess{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int ends = points[next][axis] + points[before][axis];
      guess[axis] = clamp_coordinate(slots.known[across] ? ends - points[across][axis] : ends / 2);
    }
    return guess;
  }
  const std::array<int, 3> centre = known_centre(slots);
  for (std::size_t neighbour : {before, next}) {
    if (!slots.known[neighbour]) continue;
    // A quarter of the way in: merged leaves lie about their parent.
    QuantisedPoint guess{};
    for (std::size_t axis = 0; axis < 3; ++axis) guess[axis] = clamp_coordinate((3 * points[neighbour][axis] + centre[axis]) / 4);
    return guess;
  }
  if (slots.known[across]) return points[across];
  return {clamp_coordinate(centre[0]), clamp_coordinate(centre[1]), clamp_coordinate(centre[2])};
}

std::array<std::uint8_t, 4> slots_of_rank(std::uint32_t set, std::uint32_t order) {
  std::array<std::uint8_t, 4> sorted{};
  for (std::uint32_t i = 4; i-- > 0;) {
    std::uint32_t slot = i;
    while (binomial(slot + 1, i + 1) <= set) ++slot;
    set -= binomial(slot, i + 1);
    sorted[i] = static_cast<std::uint8_t>(slot);
  }
  const std::array<std::uint32_t, 4> places = {order / 6, order / 2 % 3, order % 2, 0};
  std::array<std::uint8_t, 4> parent_slots{};
  for (std::size_t i = 0; i < 4; ++i) {
    parent_slots[i] = sorted[places[i]];
    std::copy(sorted.begin() + places[i] + 1, sorted.end(), sorted.begin() + places[i]);
  }
  return parent_slots;
}

}  // namespace coppice::page_draco_layout
