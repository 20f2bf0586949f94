#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "visibility.h"

namespace coppice::bake {

/// The leaves at each pixel of one view while leaves come and go, nearest first. A list that outgrows its place moves to the end of the
/// pool.
class FragmentLists {
 public:
  static constexpr LeafFragment kNothing = ~LeafFragment{0};  ///< behind every leaf; its leaf is kNone

  FragmentLists() = default;
  /// No leaves.
  explicit FragmentLists(std::uint32_t pixel_count) : heads_(pixel_count), lists_(pixel_count) {}
  FragmentLists(const ItemBuffers& buffers, std::uint32_t view);

  /// The nearest fragment or kNothing. Dense, as is behind(): what most questions need.
  [[nodiscard]] LeafFragment front(std::uint32_t pixel) const { return heads_[pixel].front; }
  /// The second nearest or kNothing.
  [[nodiscard]] LeafFragment behind(std::uint32_t pixel) const { return heads_[pixel].behind; }
  /// The nearest that is neither of two leaves.
  [[nodiscard]] LeafFragment front_without(std::uint32_t pixel, std::uint32_t first, std::uint32_t second) const {
    const auto is_either = [&](LeafFragment fragment) { return fragment_leaf(fragment) == first || fragment_leaf(fragment) == second; };
    const Head& head = heads_[pixel];
    if (!is_either(head.front)) return head.front;
    return is_either(head.behind) ? third(pixel) : head.behind;
  }
  /// All of them, nearest first.
  [[nodiscard]] std::span<const LeafFragment> at(std::uint32_t pixel) const {
    return std::span(pool_).subspan(lists_[pixel].begin, lists_[pixel].count);
  }
  void insert(std::uint32_t pixel, LeafFragment fragment);
  /// fragment  must be there (asserted)
  void remove(std::uint32_t pixel, LeafFragment fragment);

 private:
  struct PixelList {
    std::uint32_t begin = 0, count = 0, capacity = 0;
  };
  struct Head {
    LeafFragment front = kNothing, behind = kNothing;
  };

  [[nodiscard]] LeafFragment third(std::uint32_t pixel) const;
  void set_head(std::uint32_t pixel);

  std::vector<Head> heads_;       ///< [pixel]
  std::vector<PixelList> lists_;  ///< [pixel] ascending
  std::vector<LeafFragment> pool_;
};

}  // namespace coppice::bake
