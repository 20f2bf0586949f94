#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "hooks.h"

namespace coppice {

/// A list whose memory comes from the allocator hook and is reserved before it is filled, so that filling it cannot fail.
template <class T>
struct BoundedList {
  HookArray<T> items;     ///< the reserved elements
  std::size_t count = 0;  ///< number of elements in use

  /// Ensures a capacity without keeping the elements. If it must grow it grows by at least a half. errors  out_of_memory; the list stays as
  /// it is
  Result<void> make_room(const coppice_allocator& allocator, std::size_t room) {
    if (room <= items.size()) return {};
    COPPICE_CHECK(allocate_into(items, allocator, std::max(room, items.size() + items.size() / 2)));
    count = 0;
    return {};
  }
  /// Ensures a capacity and keeps the elements. errors  out_of_memory; the list stays as it is
  Result<void> reserve(const coppice_allocator& allocator, std::size_t room) {
    return room <= items.size() ? Result<void>() : move_into(items, enlarged_copy(items, allocator, room));
  }
  /// Adds an element; grows by a half if it is full. errors  out_of_memory; the list stays as it is
  Result<void> append(const coppice_allocator& allocator, const T& item) {
    constexpr std::size_t kFirst = 16;
    if (count == items.size()) COPPICE_CHECK(reserve(allocator, std::max(kFirst, count + count / 2)));
    push_back(item);
    return {};
  }
  void clear() { count = 0; }
  void push_back(const T& item) { items[count++] = item; }
  /// Removes matching elements and keeps the order of the others.
  template <class Goes>
  void erase_if(Goes goes) {
    count = static_cast<std::size_t>(std::remove_if(span().begin(), span().end(), goes) - span().begin());
  }
  /// Removes and returns the last element. before: not empty
  T pop_back() { return items[--count]; }
  /// Empties the list, and returns its elements until the next one is added.
  std::span<const T> take_all() { return items.span().first(std::exchange(count, 0)); }
  /// Extends the list to this many elements, within its capacity. New elements are default-constructed.
  void extend(std::size_t to) { count = std::max(count, to); }
  [[nodiscard]] T& operator[](std::size_t i) { return span()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return span()[i]; }
  [[nodiscard]] bool empty() const { return count == 0; }
  [[nodiscard]] bool full() const { return count == items.size(); }
  [[nodiscard]] std::span<T> span() { return items.span().first(count); }
  [[nodiscard]] std::span<const T> span() const { return items.span().first(count); }
};

}  // namespace coppice
