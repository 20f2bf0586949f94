#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "check.h"
#include "visibility.h"

namespace coppice::bake {

/// Lies behind every leaf. Its leaf is kNone.
inline constexpr LeafFragment kNothing = ~LeafFragment{0};

[[nodiscard]] inline LeafFragment fragment_of(LeafFragment entry) {
  return entry;
}

/// The leaves at each pixel of one view, nearest first, while leaves come and go. A list that outgrows its place moves to the end of the
/// pool.
/// Entry  LeafFragment, or that with data for a walk; fragment_of(entry)
template <class Entry>
class PixelLists {
 public:
  PixelLists() = default;
  /// Starts without leaves.
  explicit PixelLists(std::uint32_t pixel_count) : heads_(pixel_count), lists_(pixel_count) {}
  /// entry_of(fragment) makes the entries.
  template <class EntryOf>
  PixelLists(const ItemBuffers& buffers, std::uint32_t view, EntryOf&& entry_of)
      : heads_(buffers.pixels_per_view()), lists_(buffers.pixels_per_view()) {
    for (std::uint32_t pixel = 0; pixel < buffers.pixels_per_view(); ++pixel) {
      const std::span<const LeafFragment> fragments = buffers.at(view, pixel);
      const auto count = static_cast<std::uint32_t>(fragments.size());
      lists_[pixel] = {static_cast<std::uint32_t>(pool_.size()), count, count};
      for (const LeafFragment fragment : fragments) pool_.push_back(entry_of(fragment));
      set_head(pixel);
    }
  }

  /// The nearest fragment or kNothing. This and behind() are stored densely: most queries need no more.
  [[nodiscard]] LeafFragment front(std::uint32_t pixel) const { return heads_[pixel].front; }
  /// The second nearest or kNothing.
  [[nodiscard]] LeafFragment behind(std::uint32_t pixel) const { return heads_[pixel].behind; }
  /// The nearest fragment that is neither leaf's.
  [[nodiscard]] LeafFragment front_without(std::uint32_t pixel, std::uint32_t first, std::uint32_t second) const {
    const auto is_either = [&](LeafFragment fragment) { return fragment_leaf(fragment) == first || fragment_leaf(fragment) == second; };
    const Head& head = heads_[pixel];
    if (!is_either(head.front)) return head.front;
    return is_either(head.behind) ? fragment_at(pixel, 2) : head.behind;
  }
  /// All fragments, nearest first.
  [[nodiscard]] std::span<const Entry> at(std::uint32_t pixel) const {
    return std::span(pool_).subspan(lists_[pixel].begin, lists_[pixel].count);
  }
  /// Lists lie anywhere in memory, and waiting for it is most of a walk's time. These prefetch some pixels ahead: first the list, then,
  /// once that has arrived, its entries.
  void prefetch_list(std::uint32_t pixel) const { __builtin_prefetch(&lists_[pixel]); }
  void prefetch_entries(std::uint32_t pixel) const {
    constexpr std::uint32_t kOfLine = 64 / sizeof(Entry);
    const List& list = lists_[pixel];
    __builtin_prefetch(pool_.data() + list.begin);
    __builtin_prefetch(pool_.data() + list.begin + std::min(kOfLine, list.count));
  }

  void insert(std::uint32_t pixel, const Entry& entry) {
    List& list = lists_[pixel];
    if (list.count == list.capacity) {
      const auto moved = static_cast<std::uint32_t>(pool_.size());
      list.capacity = std::max(4u, list.capacity * 2);
      pool_.resize(pool_.size() + list.capacity);
      std::copy_n(pool_.begin() + list.begin, list.count, pool_.begin() + moved);
      list.begin = moved;
    }
    const auto place = place_of(list, fragment_of(entry)), end = pool_.begin() + list.begin + list.count;
    std::copy_backward(place, end, end + 1);
    *place = entry;
    ++list.count;
    set_head(pixel);
  }
  /// fragment  must be there (asserted)
  void remove(std::uint32_t pixel, LeafFragment fragment) {
    List& list = lists_[pixel];
    const auto place = place_of(list, fragment), end = pool_.begin() + list.begin + list.count;
    COPPICE_ASSERT(place != end && fragment_of(*place) == fragment);
    std::copy(place + 1, end, place);
    --list.count;
    set_head(pixel);
  }

 private:
  struct List {
    std::uint32_t begin = 0, count = 0, capacity = 0;
  };
  struct Head {
    LeafFragment front = kNothing, behind = kNothing;
  };

  [[nodiscard]] auto place_of(const List& list, LeafFragment fragment) {
    return std::lower_bound(pool_.begin() + list.begin, pool_.begin() + list.begin + list.count, fragment,
                            [](const Entry& entry, LeafFragment than) { return fragment_of(entry) < than; });
  }
  [[nodiscard]] LeafFragment fragment_at(std::uint32_t pixel, std::uint32_t place) const {
    return lists_[pixel].count > place ? fragment_of(pool_[lists_[pixel].begin + place]) : kNothing;
  }
  void set_head(std::uint32_t pixel) { heads_[pixel] = {fragment_at(pixel, 0), fragment_at(pixel, 1)}; }

  std::vector<Head> heads_;  ///< [pixel]
  std::vector<List> lists_;  ///< [pixel] ascending
  std::vector<Entry> pool_;
};

}  // namespace coppice::bake
