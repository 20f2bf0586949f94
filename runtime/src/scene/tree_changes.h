#pragma once

// The trees of a scene that are not as in its file. They are few: one sorted list, which is rewritten when it grows.

#include <cstdint>
#include <span>
#include <tuple>

#include "bounded_list.h"
#include "coppice/coppice.h"

namespace coppice {

struct TreeChange {
  std::uint32_t tile = 0, number = 0;
  coppice_tree_state state = COPPICE_TREE_AS_IN_FILE;
  // The replacement, in the scene's space. No plant: the tree's own.
  coppice_plant plant = 0;
  coppice_placement placement{};
  // The tree in the file, in the scene's space; known once its tile has been resident since the change. No plant: it has failed.
  coppice_plant own_plant = 0;
  coppice_placement own_placement{};

  [[nodiscard]] auto key() const { return std::tuple(tile, number); }
};

class TreeChanges {
 public:
  /// Reserves memory for this many more. errors  out_of_memory: the allocator hook
  Result<void> reserve(const coppice_allocator& allocator, std::size_t added) { return changes_.reserve(allocator, room_for(added)); }
  /// Bytes that reserve would allocate.
  [[nodiscard]] std::uint64_t growth_bytes(std::size_t added) const {
    return (room_for(added) - changes_.items.size()) * sizeof(TreeChange);
  }

  /// Adds trees that are not in the list, with their state in the file. before: memory is reserved
  void add(std::span<const coppice_scene_tree> trees, coppice_scene scene);
  /// Removes trees that are as in the file.
  void tidy();
  /// Ordered by tile and number.
  [[nodiscard]] std::span<const TreeChange> all() const { return changes_.span(); }
  /// Null if it is as in the file.
  [[nodiscard]] TreeChange* find(std::uint32_t tile, std::uint32_t number);
  [[nodiscard]] const TreeChange* find(std::uint32_t tile, std::uint32_t number) const {
    return const_cast<TreeChanges*>(this)->find(tile, number);
  }
  /// Those of a tile, ordered by number.
  [[nodiscard]] std::span<TreeChange> of_tile(std::uint32_t tile);
  [[nodiscard]] std::span<const TreeChange> of_tile(std::uint32_t tile) const { return const_cast<TreeChanges*>(this)->of_tile(tile); }
  [[nodiscard]] std::uint64_t bytes() const { return changes_.items.bytes(); }

 private:
  [[nodiscard]] std::size_t room_for(std::size_t added) const;

  BoundedList<TreeChange> changes_;  ///< ordered by key()
};

}  // namespace coppice
