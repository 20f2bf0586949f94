#include "fragment_lists.h"

#include <algorithm>

#include "check.h"

namespace coppice::bake {

FragmentLists::FragmentLists(const ItemBuffers& buffers, std::uint32_t view)
    : front_(buffers.pixels_per_view(), kNothing), lists_(buffers.pixels_per_view()) {
  for (std::uint32_t pixel = 0; pixel < buffers.pixels_per_view(); ++pixel) {
    const std::span<const LeafFragment> fragments = buffers.at(view, pixel);
    const auto count = static_cast<std::uint32_t>(fragments.size());
    lists_[pixel] = {static_cast<std::uint32_t>(pool_.size()), count, count};
    pool_.insert(pool_.end(), fragments.begin(), fragments.end());
    if (count > 0) front_[pixel] = fragments.front();
  }
}

LeafFragment FragmentLists::front_without(std::uint32_t pixel, std::uint32_t first, std::uint32_t second) const {
  const PixelList& list = lists_[pixel];
  for (std::uint32_t i = 0; i < list.count; ++i) {
    const LeafFragment fragment = pool_[list.begin + i];
    if (fragment_leaf(fragment) != first && fragment_leaf(fragment) != second) return fragment;
  }
  return kNothing;
}

void FragmentLists::insert(std::uint32_t pixel, LeafFragment fragment) {
  PixelList& list = lists_[pixel];
  if (list.count == list.capacity) {
    const auto moved = static_cast<std::uint32_t>(pool_.size());
    list.capacity = std::max(4u, list.capacity * 2);
    pool_.resize(pool_.size() + list.capacity);
    std::copy_n(pool_.begin() + list.begin, list.count, pool_.begin() + moved);
    list.begin = moved;
  }
  const auto end = pool_.begin() + list.begin + list.count;
  const auto place = std::lower_bound(pool_.begin() + list.begin, end, fragment);
  std::copy_backward(place, end, end + 1);
  *place = fragment;
  ++list.count;
  front_[pixel] = pool_[list.begin];
}

void FragmentLists::remove(std::uint32_t pixel, LeafFragment fragment) {
  PixelList& list = lists_[pixel];
  const auto end = pool_.begin() + list.begin + list.count;
  const auto place = std::lower_bound(pool_.begin() + list.begin, end, fragment);
  COPPICE_ASSERT(place != end && *place == fragment);
  std::copy(place + 1, end, place);
  --list.count;
  front_[pixel] = list.count == 0 ? kNothing : pool_[list.begin];
}

}  // namespace coppice::bake
