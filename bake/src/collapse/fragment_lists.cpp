#include "fragment_lists.h"

#include <algorithm>

#include "check.h"

namespace coppice::bake {

FragmentLists::FragmentLists(const ItemBuffers& buffers, std::uint32_t view)
    : heads_(buffers.pixels_per_view()), lists_(buffers.pixels_per_view()) {
  for (std::uint32_t pixel = 0; pixel < buffers.pixels_per_view(); ++pixel) {
    const std::span<const LeafFragment> fragments = buffers.at(view, pixel);
    const auto count = static_cast<std::uint32_t>(fragments.size());
    lists_[pixel] = {static_cast<std::uint32_t>(pool_.size()), count, count};
    pool_.insert(pool_.end(), fragments.begin(), fragments.end());
    set_head(pixel);
  }
}

LeafFragment FragmentLists::third(std::uint32_t pixel) const {
  return lists_[pixel].count > 2 ? pool_[lists_[pixel].begin + 2] : kNothing;
}

void FragmentLists::set_head(std::uint32_t pixel) {
  const PixelList& list = lists_[pixel];
  heads_[pixel] = {list.count > 0 ? pool_[list.begin] : kNothing, list.count > 1 ? pool_[list.begin + 1] : kNothing};
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
  set_head(pixel);
}

void FragmentLists::remove(std::uint32_t pixel, LeafFragment fragment) {
  PixelList& list = lists_[pixel];
  const auto end = pool_.begin() + list.begin + list.count;
  const auto place = std::lower_bound(pool_.begin() + list.begin, end, fragment);
  COPPICE_ASSERT(place != end && *place == fragment);
  std::copy(place + 1, end, place);
  --list.count;
  set_head(pixel);
}

}  // namespace coppice::bake
