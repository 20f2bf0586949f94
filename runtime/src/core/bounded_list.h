#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "hooks.h"

namespace coppice {

/// A list whose room is made before it is filled, out of the allocator hook: filling it cannot fail.
template <class T>
struct BoundedList {
  HookArray<T> items;     ///< the room
  std::size_t count = 0;  ///< of them in use

  /// Makes room for so many and, where there is less, for half as many more than now; what is in the list goes. errors  out_of_memory; the
  /// list stays as it is
  Result<void> make_room(const coppice_allocator& allocator, std::size_t room) {
    if (room <= items.size()) return {};
    COPPICE_CHECK(allocate_into(items, allocator, std::max(room, items.size() + items.size() / 2)));
    count = 0;
    return {};
  }
  void clear() { count = 0; }
  void push_back(const T& item) { items[count++] = item; }
  /// Takes the last. Not empty
  T pop_back() { return items[--count]; }
  [[nodiscard]] bool empty() const { return count == 0; }
  [[nodiscard]] std::span<T> span() { return items.span().first(count); }
  [[nodiscard]] std::span<const T> span() const { return items.span().first(count); }
};

}  // namespace coppice
