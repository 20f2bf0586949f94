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

  /// Makes room for so many and, where there is less, for half as many more than now, whereupon what is in the list goes. errors
  /// out_of_memory; the list stays as it is
  Result<void> make_room(const coppice_allocator& allocator, std::size_t room) {
    if (room <= items.size()) return {};
    COPPICE_CHECK(allocate_into(items, allocator, std::max(room, items.size() + items.size() / 2)));
    count = 0;
    return {};
  }
  /// Makes room for so many, and keeps what is in the list. errors  out_of_memory; the list stays as it is
  Result<void> reserve(const coppice_allocator& allocator, std::size_t room) {
    return room <= items.size() ? Result<void>() : move_into(items, enlarged_copy(items, allocator, room));
  }
  /// Adds one; makes room for half as many more where there is none. errors  out_of_memory; the list stays as it is
  Result<void> append(const coppice_allocator& allocator, const T& item) {
    constexpr std::size_t kFirst = 16;
    if (count == items.size()) COPPICE_CHECK(reserve(allocator, std::max(kFirst, count + count / 2)));
    push_back(item);
    return {};
  }
  void clear() { count = 0; }
  void push_back(const T& item) { items[count++] = item; }
  /// Keeps the order of the others.
  template <class Goes>
  void erase_if(Goes goes) {
    count = static_cast<std::size_t>(std::remove_if(span().begin(), span().end(), goes) - span().begin());
  }
  /// Takes the last. Not empty
  T pop_back() { return items[--count]; }
  /// So many at least; there is room for them. New ones are as they were made.
  void extend(std::size_t to) { count = std::max(count, to); }
  [[nodiscard]] T& operator[](std::size_t i) { return span()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return span()[i]; }
  [[nodiscard]] bool empty() const { return count == 0; }
  [[nodiscard]] std::span<T> span() { return items.span().first(count); }
  [[nodiscard]] std::span<const T> span() const { return items.span().first(count); }
};

}  // namespace coppice
